"""Pictures and hits by Dask: bytes are those of one process, whoever computed them."""

import gc
import os
import signal
import time
from collections import Counter
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import dask
import dask.array as da
import kugelblitz as kb
import kugelblitz.dask as kd
import numpy as np
import pytest
from conftest import cloud, refuses
from distributed import Client, LocalCluster

SIZE = (160, 120)


@contextmanager
def cluster_of(n_workers, **options):
    options = {"threads_per_worker": 1, "processes": True, "dashboard_address": ":0", "memory_limit": 0, **options}
    with LocalCluster(n_workers=n_workers, **options) as cluster, Client(cluster) as client:
        client.wait_for_workers(n_workers, timeout=120)
        yield client


@pytest.fixture(scope="module")
def client():
    with cluster_of(3) as client:
        yield client


@pytest.fixture
def counted(tmp_path, monkeypatch):
    """Starts a cluster that counts which processes unpickle scenes."""
    log = tmp_path / "scenes.log"
    log.touch()
    monkeypatch.setenv("COUNT_SCENES", str(log))
    preload = str(Path(__file__).with_name("preload_count.py"))

    @contextmanager
    def start(n_workers):
        with cluster_of(n_workers, preload=[preload]) as client:
            yield client, lambda: Counter(log.read_text().split())

    return start


def pids(client):
    return {address: str(pid) for address, pid in client.run(os.getpid).items()}


def wait_until(holds, seconds=60):
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, "nothing came of it"
        time.sleep(0.02)


def test_without_a_client_threads_draw(camera):
    # The first test, as a client stays the current one.
    scene = cloud(300)
    for scheduler in ["threads", "synchronous"]:
        with dask.config.set(scheduler=scheduler):
            array = kd.render(scene, camera, SIZE, rows=50)
            assert (array.compute() == scene.render(camera, SIZE).rgb8).all()


def test_bands_are_the_picture(client, camera):
    scene = cloud(3000, lights=[dict(position="eye")])
    alone = scene.render(camera, SIZE, samples=2)
    for field in kd.FIELDS:
        array = kd.render(scene, camera, SIZE, field=field, client=client, samples=2)
        assert array.numblocks[0] == 12 and array.shape[:2] == (120, 160)
        found = array.compute()
        assert found.dtype == array.dtype and found.tobytes() == getattr(alone, field).tobytes(), field
    uneven = kd.render(scene, camera, SIZE, rows=50, samples=2)
    assert uneven.numblocks[0] == 3 and (client.compute(uneven).result() == alone.rgb8).all()


def test_wrong_arguments_are_named_before_any_work(camera):
    rays = dict(origins=np.zeros((2, 3)), directions=np.ones((2, 3)))
    for call, *cases in [
        (
            partial(kd.render, camera=camera, size=SIZE),
            (dict(field="rgb9"), "rgb9.*rgb8"), (dict(rows=0), "rows"),
            (dict(size=(0, 10)), "size"), (dict(size=(-5, 10)), "size"), (dict(size=(10.9, 10)), "size"),
            (dict(crop=(0, 0, 5, 5)), "crop"), (dict(samples=17), "samples"), (dict(device=""), "device"), (dict(sample=2), "sample"),
        ),
        (
            partial(kd.frames, cameras=[camera], size=SIZE),
            (dict(cameras=[]), "cameras"), (dict(size=(10**6, 10)), "size"), (dict(kernel="certfied"), "certified"),
            (dict(cameras=["me"]), "camera|str"),
        ),
        (
            partial(kd.trace, **rays),
            (dict(origins=np.zeros((2, 2)), directions=np.zeros((2, 2))), r"origins.*\(N, 3\)"),
            (dict(directions=np.zeros((3, 3))), "directions: 3 rows"), (dict(kernel="all"), "kernel"), (dict(progress=True), "progress"),
        ),
    ]:
        refuses(partial(call, cloud(5)), (ValueError, TypeError), *cases)
    refuses(partial(kd.render, kb.Scene()), ValueError, (dict(size=SIZE), "^camera: .*no spheres"))


def test_a_scene_has_its_own_size_and_camera(client, camera):
    scene = cloud(50).replace(size=(40, 30), camera=camera)
    array = kd.render(scene, client=client)
    assert array.shape == (30, 40, 3) and (array.compute() == scene.render().rgb8).all()
    assert kd.frames(scene, [camera], client=client).shape == (1, 30, 40, 3)
    # Without a camera, all bands are of one that frames the whole picture.
    array = kd.render(cloud(50), size=(40, 30), rows=10, client=client)
    assert (array.compute() == cloud(50).render(size=(40, 30)).rgb8).all()


def test_bands_are_small(client):
    assert kd._band_rows(160, 120, client) == 10
    assert kd._band_rows(1 << 14, 1 << 14, client) * (1 << 14) <= kd.BAND_PIXELS
    assert kd._band_rows(10**7, 5, None) == 1


def test_frames_and_rays(client, camera):
    scene = cloud(500)
    cameras = [kb.Camera((2 + n, 1, 2), (0.5, 0.5, 0.5)) for n in range(3)]
    frames = kd.frames(scene, cameras, SIZE, client=client).compute()
    for frame, camera in zip(frames, cameras):
        assert (frame == scene.render(camera, SIZE).rgb8).all()
    rng = np.random.default_rng(3)
    origins, directions = rng.random((2, 1000, 3))
    hits = kd.trace(scene, da.from_array(origins, chunks=300), directions - 0.5, client=client)
    hits, alone = hits.compute(), scene.trace(origins, directions - 0.5)
    for field in ["id", "t", "normal"]:
        assert hits[field].tobytes() == np.ascontiguousarray(alone[field]).tobytes()


def test_devices_that_differ_give_the_same_bytes(client, camera):
    """One worker draws on lavapipe, one on the CPU, one where it likes."""
    scene = cloud(800, lights=[dict(position=[3, 4, 2])])
    alone = scene.render(camera, SIZE, samples=2)
    bands = {}
    futures = {}
    for worker, device in zip(client.nthreads(), ["cpu", "gpu", "auto"]):
        bands[device] = kd.render(scene, camera, SIZE, client=client, samples=2, device=device, rows=30)
        futures[device] = client.compute(bands[device], workers=[worker], allow_other_workers=False)
    for device, future in futures.items():
        assert (future.result(timeout=120) == alone.rgb8).all(), device
    # Half of one picture by each.
    halves = [bands["gpu"][:60], bands["cpu"][60:]]
    assert (da.concatenate(halves).compute() == alone.rgb8).all()


def test_a_band_that_is_computed_twice_changes_nothing(client, camera):
    scene = cloud(400)
    array = kd.render(scene, camera, SIZE, client=client, rows=40)
    first, again = client.compute(array), client.compute(array * 1)
    assert (first.result() == again.result()).all()


def test_a_worker_that_dies_changes_nothing(camera, counted):
    """Killed amid its work: the picture is the same, and no worker got the scene twice."""
    scene = cloud(20_000, sky=dict(intensity=1))
    size = (400, 300)
    alone = scene.render(camera, size).rgb8
    with counted(2) as (client, unpickled):
        before = pids(client)
        array = kd.render(scene, camera, size, client=client, rows=10)
        assert unpickled() == {pid: 1 for pid in before.values()}
        victim = next(iter(before))
        # Held, so that it has its bands and has not finished them, however quick the machine is.
        os.kill(int(before[victim]), signal.SIGSTOP)
        future = client.compute(array)
        wait_until(lambda: client.processing()[victim])
        assert not future.done()
        os.kill(int(before[victim]), signal.SIGKILL)
        assert (future.result(timeout=240) == alone).all()
        wait_until(lambda: len(client.nthreads()) == 2)
        after = pids(client)
        assert before[victim] not in after.values()
        # Another picture finds the scene in place, also on the worker that came anew.
        again = kd.render(scene, camera, SIZE, client=client)
        assert (again.compute() == scene.render(camera, SIZE).rgb8).all()
        assert unpickled() == {pid: 1 for pid in {*before.values(), *after.values()}}


def test_all_workers_may_die(camera):
    scene = cloud(500)
    with cluster_of(1) as client:
        array = kd.render(scene, camera, SIZE, client=client)
        os.kill(int(*pids(client).values()), signal.SIGKILL)
        assert (client.compute(array).result(timeout=120) == scene.render(camera, SIZE).rgb8).all()


def test_scenes_leave_the_workers_when_nobody_needs_them(camera):
    def held(dask_worker):
        return sum(name.startswith(kd._PREFIX) for name in dask_worker.plugins)

    with cluster_of(1) as client:
        first = cloud(50)
        alone = first.render(camera, SIZE).rgb8
        array = kd.render(first, camera, SIZE, client=client)
        kd.render(first, camera, SIZE, client=client)
        assert list(client.run(held).values()) == [1]
        # Two scenes later it is none of the last ones, but its results need it.
        kept = array.persist()
        del array, first
        for n in range(3):
            kd.render(cloud(60 + n), camera, SIZE, client=client)
            gc.collect()
            time.sleep(0.3)
        assert list(client.run(held).values()) == [1 + kd._LAST_SCENES]
        assert (kept.compute() == alone).all()
        del kept
        gc.collect()
        time.sleep(0.5)
        kd.render(cloud(70), camera, SIZE, client=client)
        assert list(client.run(held).values()) == [kd._LAST_SCENES]
