"""Pictures and hits: what arrays hold, what files hold, threads, forks and signals."""

import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from functools import partial

import kugelblitz as kb
import numpy as np
import pytest
from conftest import cloud, in_threads, refuses

FORK = multiprocessing.get_context("fork")


def in_forks(*works):
    """What children of this process make, each of its own work."""
    queue = FORK.Queue()
    children = [FORK.Process(target=lambda work=work: queue.put(work())) for work in works]
    [child.start() for child in children]
    try:
        found = [queue.get(timeout=60) for _ in children]
        [child.join(60) for child in children]
        assert not any(child.exitcode for child in children)
        return found
    finally:
        [child.kill() for child in children]


def test_files_hold_what_arrays_hold(tmp_path, camera):
    scene = cloud(2000, lights=[dict(position="eye")])
    picture = scene.render(camera, (96, 64), samples=2)
    picture.save(tmp_path / "p.npy", certificates=True)
    array = np.load(tmp_path / "p.npy")
    for field in ["id", "t", "normal", "rgb", "level"]:
        assert (array[field] == getattr(picture, field)).all(), field
    picture.save(tmp_path / "p.ppm")
    ppm = (tmp_path / "p.ppm").read_bytes()
    assert ppm.endswith(picture.rgb8.tobytes()) and ppm.startswith(b"P6\n96 64\n255\n")
    picture.save(tmp_path / "p.png")
    assert (tmp_path / "p.png").read_bytes() == picture._repr_png_()
    for name in ["p16.png", "p.exr"]:
        picture.save(tmp_path / name, bits=16)
        assert (tmp_path / name).stat().st_size > 1000
    assert sorted(os.listdir(tmp_path)) == ["p.exr", "p.npy", "p.png", "p.ppm", "p16.png"]


def test_wrong_options_change_no_file(tmp_path, camera, ball):
    picture = ball.render(camera, (8, 8))
    (tmp_path / "p.png").write_text("old")
    refuses(
        picture.save, ValueError,
        (dict(path=tmp_path / "p.jpg"), "jpg"),
        (dict(path=tmp_path / "p.png", bits=12), "12"),
        (dict(path=tmp_path / "p.png", certificates=True), "certificates"),
    )
    assert (tmp_path / "p.png").read_text() == "old" and os.listdir(tmp_path) == ["p.png"]
    refuses(
        partial(ball.render, camera, size=(8, 8)), ValueError,
        (dict(size=(0, 5)), "size"),
        (dict(size=(10**6, 5)), "size"),
        (dict(crop=(5, 5, 5, 5)), "crop"),
        (dict(crop=(2**32 - 1, 0, 2, 2)), "crop"),
        (dict(crop=(0, 0, 0, 1)), "crop"),
        (dict(samples=0), "samples"),
        (dict(samples=17), "samples"),
        (dict(kernel="certfied"), "certified"),
        (dict(epsilon=1e-3), "epsilon"),
        (dict(epsilon=float("nan"), kernel="stable"), "epsilon"),
        (dict(device=""), "device"),
    )
    refuses(kb.Scene().render, ValueError, ({}, "camera"))
    nobody = dict(camera=camera, device="nobody's card")
    for call, given in [(ball.render, {}), (ball.verify, dict(kernel="all")), (ball.explain, dict(pixel=(1, 1)))]:
        refuses(call, kb.NoAdapterError, (nobody | given, "nobody's card"))


def test_parts_and_transparency(camera):
    scene = cloud(300)
    whole = scene.render(camera, (60, 40), samples=3)
    part = scene.render(camera, (60, 40), samples=3, crop=(10, 5, 20, 30))
    assert (whole.rgb8[5:35, 10:30] == part.rgb8).all()
    assert (whole.id[5:35, 10:30] == part.id).all()
    assert whole.alpha is None
    clear = scene.render(camera, (60, 40), samples=3, transparent=True)
    assert clear.alpha.min() == 0 and clear.alpha.max() == 1
    assert ((clear.alpha > 0) & (clear.alpha < 1)).any()


def test_every_device_gives_the_same_bytes(camera):
    scene = cloud(500, lights=[dict(position=[3, 4, 2])])
    digests = {scene.render(camera, (80, 60), device=d).digest() for d in ["cpu", "gpu", "auto"]}
    assert len(digests) == 1 and digests.pop().startswith("kb2:")
    assert kb.adapters()[0]["name"]


@pytest.mark.parametrize("device", ["cpu", "gpu"])
@pytest.mark.parametrize("kernel", ["certified", "stable"])
def test_depths_are_the_same_whenever_they_are_traced(camera, device, kernel):
    scene = cloud(500, lights=[dict(position="eye")])
    draw = partial(scene.render, camera, (64, 48), samples=2, device=device, kernel=kernel)
    later, other = draw(), draw()
    assert other.t.shape == (48, 64)
    # From now on they are kept from the start.
    at_once = draw()
    assert later.counts == at_once.counts and (later.level == at_once.level).all()
    for field in ["id", "rgb8", "t", "normal"]:
        assert (getattr(later, field) == getattr(at_once, field)).all(), field
    assert (np.isfinite(later.t) == (later.id > 0)).all()
    del scene, draw
    assert later.digest() == at_once.digest()


def test_threads_and_a_fork_ask_for_depths(camera):
    """The fork comes while threads trace them."""
    def ask(number):
        time.sleep(number / 100)
        found.extend(in_forks(lambda: picture.t) if number == 3 else [picture.t])

    expected = cloud(3000).render(camera, (1200, 900)).t
    picture, found = cloud(3000).render(camera, (1200, 900)), []
    in_threads(5, ask)
    assert len(found) == 5 and all((t == expected).all() for t in found)


def test_rays_see_what_pixels_see(camera):
    scene = cloud(1000)
    origins = np.tile(camera.position, (500, 1))
    targets = np.random.default_rng(2).random((500, 3))
    hits = scene.trace(origins, targets - origins)
    assert isinstance(hits, kb.Hits) and len(hits) == 500 and sum(hits.counts.values()) == 500
    assert hits.id.max() <= 1000 and (np.isinf(hits.t) == (hits.id == 0)).all()
    # The hit lies on its sphere.
    at = hits.id > 0
    point = origins[at] + hits.t[at, None].astype(float) * (targets - origins)[at]
    row = scene.spheres[hits.id[at] - 1]
    distance = np.linalg.norm(point - row[:, :3], axis=1)
    assert np.allclose(distance, row[:, 3], rtol=1e-4) and at.sum() > 100
    on_device = scene.trace(origins, targets - origins, device="gpu")
    for field in ["id", "t", "normal"]:
        assert (hits[field] == on_device[field]).all()
    assert len(scene.trace(np.zeros((0, 3)), np.zeros((0, 3)))) == 0
    origins, directions = np.zeros((2, 3)), np.ones((2, 3))
    refuses(
        partial(scene.trace, origins=origins, directions=directions), ValueError,
        (dict(directions=np.ones((3, 3))), "directions"),
        (dict(origins=np.zeros((2, 2))), "origins"),
        (dict(directions=[[1, 1, 1], [0, 0, 0]]), "row 1"),
        (dict(origins=np.full((2, 3), np.inf)), "finite"),
    )


def test_2_to_the_32_rows_are_refused_or_run_out_of_memory(ball):
    many = np.broadcast_to(np.ones(3), (2**32, 3))
    with pytest.raises((MemoryError, ValueError)):
        ball.trace(many, many)
    with pytest.raises((MemoryError, ValueError)):
        kb.Scene(many, radius=1)


def test_progress_is_told_and_an_exception_in_it_stops_the_work(camera):
    scene = cloud(20_000, sky=dict(intensity=1))
    told = []
    scene.render(camera, (400, 300), progress=lambda done, total: told.append((done, total)))
    assert told[-1][0] == told[-1][1] and all(done <= total for done, total in told)

    class Bar:
        n, total = 0, 0

        def update(self, more):
            self.n += more

    bar = Bar()
    scene.render(camera, (100, 75), progress=bar)
    assert bar.n == bar.total > 0
    scene.render(camera, (40, 30), progress=True)

    def stop(done, total):
        raise RuntimeError("enough")

    start = time.monotonic()
    with pytest.raises(RuntimeError, match="enough"):
        scene.render(camera, (4000, 3000), progress=stop)
    assert time.monotonic() - start < 30
    with pytest.raises(TypeError, match="progress"):
        scene.render(camera, (4, 3), progress=7)


@pytest.mark.parametrize("work", [
    "scene.render(camera, (8000, 8000))",
    "kb.Camera.frame(scene, n_turns=10_000)",
])
def test_ctrl_c_stops_the_work(work):
    # A shell may have started the tests with SIGINT ignored, and children inherit that.
    code = f"""
import kugelblitz as kb, numpy as np, signal
signal.signal(signal.SIGINT, signal.default_int_handler)
scene = kb.Scene(np.random.default_rng(1).random((1_000_000, 3)), radius=0.001, sky=dict(intensity=1))
camera = kb.Camera((2, 1, 2), (0.5, 0.5, 0.5))
scene.render(camera, (10, 10))
print("begin", flush=True)
try:
    {work}
except KeyboardInterrupt:
    print("stopped", flush=True)
scene.render(camera, (10, 10))
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "begin\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    assert out == "stopped\n" and process.returncode == 0


def test_no_call_waits_for_others_with_the_interpreter(camera):
    """While one thread draws, others make scenes and run, also while a call waits for the threads that draw."""
    scene = cloud(20_000, sky=dict(intensity=1, directions=256))
    scene.render(camera, (8, 8))
    small, rows = cloud(1000), np.random.default_rng(2).random((1000, 4))
    n_made, counts, done = 0, [0], threading.Event()

    def count():
        while not done.is_set():
            counts[0] += 1
            time.sleep(0.001)

    drawing = threading.Thread(target=scene.render, args=(camera, (1200, 900)))
    counting = threading.Thread(target=count)
    drawing.start()
    counting.start()
    while drawing.is_alive() and n_made < 100:
        kb.Scene(rows, color=np.full((1000, 3), 7, np.uint8))
        n_made += 1
    assert n_made == 100 and drawing.is_alive()
    before = counts[0]
    small.trace(rows[:, :3] + 2, rows[:, :3] - 2)
    waited = drawing.is_alive()
    counted = counts[0] - before
    done.set()
    drawing.join()
    counting.join()
    # It may have been quick; where it waited for the picture, others went on.
    assert waited or counted > 50, counted


def test_threads_share_scenes(camera):
    """One that waits for another's tracing does not take its threads."""
    alone = [cloud(20_000, seed).render(camera, (160, 120)).digest() for seed in [1, 2]]
    code = """
import faulthandler, threading
import kugelblitz as kb
from conftest import cloud, in_threads
faulthandler.dump_traceback_later(100, exit=True)
scenes = [cloud(20_000, seed) for seed in [1, 2]]
camera = kb.Camera((1.9, 1.4, 2.2), (0.5, 0.5, 0.5), fov=40)
found = [set(), set()]
def draw(thread):
    for n in range(30):
        found[(n + thread) % 2].add(scenes[(n + thread) % 2].render(camera, (160, 120)).digest())
in_threads(6, draw)
print(*found[0], *found[1])
"""
    here = {**os.environ, "PYTHONPATH": os.path.dirname(__file__)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, env=here)
    assert done.stdout.split() == alone, done.stderr


@pytest.mark.parametrize("device", ["cpu", "auto"])
def test_a_fork_draws_too(camera, device):
    def draw():
        return scene.render(camera, (64, 48), device=device).digest()

    scene = cloud(1000)
    assert [draw()] == in_forks(draw)


def test_a_fork_amid_the_work_of_a_thread(camera):
    """The pool, the sessions and the device of the parent are busy when the child begins."""
    scene = cloud(20_000, sky=dict(intensity=1))
    draws = [lambda device=device: scene.render(camera, (64, 48), device=device).digest() for device in ["cpu", "gpu"]]
    digest = scene.render(camera, (64, 48), device="auto").digest()
    thread = threading.Thread(target=lambda: scene.render(camera, (640, 480), device="cpu"))
    thread.start()
    time.sleep(0.05)
    try:
        assert in_forks(*draws) == [digest] * 2
    finally:
        thread.join()


def test_a_notebook_shows_the_picture(camera):
    picture = cloud(100).render(camera, (40, 30))
    png = picture._repr_png_()
    assert png.startswith(b"\x89PNG\r\n\x1a\n") and png[16:24] == bytes([0, 0, 0, 40, 0, 0, 0, 30])
    shown = cloud(100).render(camera, (40, 30), transparent=True)._repr_png_()
    assert shown[25] == 6, "colours with alpha"


def test_arrays_are_copies_and_stay_when_the_picture_goes(camera):
    picture = cloud(100).render(camera, (40, 30))
    digest, rgb8 = picture.digest(), picture.rgb8
    old = rgb8.copy()
    picture.rgb8[:] = 7
    picture.rgb[:] = 7
    assert picture.digest() == digest and (picture.rgb8 == old).all() and not (picture.rgb == 7).all()
    del picture
    assert (rgb8 == old).all() and rgb8.flags.owndata | (rgb8.base is not None)


def test_hits_are_an_array(camera):
    scene = cloud(300)
    rng = np.random.default_rng(4)
    hits = scene.trace(rng.random((50, 3)), rng.random((50, 3)))
    assert hits.dtype.names == ("id", "t", "normal", "level")
    assert hits["t"].dtype == np.float32 and hits.normal.shape == (50, 3)
    assert hits[hits.id > 0].counts is None and hits[3].id == hits.id[3]
    assert {"f32", "f64", "exact"} == set(hits.counts)
    again = pickle.loads(pickle.dumps(hits))
    assert again.tobytes() == hits.tobytes()


def test_the_tree_is_built_once(camera):
    scene = cloud(300_000)

    def seconds(position):
        start = time.process_time()
        scene.render(kb.Camera(position, (0.5, 0.5, 0.5)), (16, 12))
        return time.process_time() - start

    first = seconds((1.9, 1.4, 2.2))
    second = min(seconds((1.9 + n / 10, 1.4, 2.2)) for n in range(3))
    assert second < first * 0.75, (first, second)
