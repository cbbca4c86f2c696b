"""Pictures and hits by Dask: bytes are those of one process, whoever computed them."""

import os
import signal
import time

import dask
import kugelblitz as kb
import kugelblitz.dask as kd
import numpy as np
import pytest
from conftest import cloud
from distributed import Client, LocalCluster

SIZE = (160, 120)


@pytest.fixture(scope="module")
def client():
    cluster = LocalCluster(
        n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None, memory_limit=0
    )
    with cluster, Client(cluster) as client:
        yield client


def test_bands_are_the_picture(client, camera):
    scene = cloud(3000, lights=[dict(position="eye")])
    alone = scene.render(camera, SIZE, samples=2)
    for field in kd.FIELDS:
        array = kd.render(scene, camera, SIZE, field=field, client=client, samples=2)
        assert array.numblocks[0] == 12 and array.shape[:2] == (120, 160)
        assert (array.compute() == getattr(alone, field)).all(), field
    with dask.config.set(scheduler="threads"):
        assert (kd.render(scene, camera, SIZE, rows=50, samples=2).compute() == alone.rgb8).all()
    with pytest.raises(ValueError, match="rgb9"):
        kd.render(scene, camera, SIZE, field="rgb9")


def test_frames_and_rays(client, camera):
    scene = cloud(500)
    cameras = [kb.Camera((2 + n, 1, 2), (0.5, 0.5, 0.5)) for n in range(3)]
    frames = kd.frames(scene, cameras, SIZE, client=client).compute()
    for frame, camera in zip(frames, cameras):
        assert (frame == scene.render(camera, SIZE).rgb8).all()
    rng = np.random.default_rng(3)
    origins, directions = rng.random((2, 1000, 3))
    import dask.array as da

    hits = kd.trace(scene, da.from_array(origins, chunks=300), directions - 0.5, client=client)
    hits, alone = hits.compute(), scene.trace(origins, directions - 0.5)
    for field in ["id", "t", "normal"]:
        assert (hits[field] == alone[field]).all()


def test_devices_that_differ_give_the_same_bytes(client, camera):
    scene = cloud(800, lights=[dict(position=[3, 4, 2])])
    workers = list(client.nthreads())
    held = client.scatter(scene, broadcast=True, hash=False)
    draw = lambda scene, device: scene.render(camera, SIZE, device=device).digest()
    jobs = [
        client.submit(draw, held, device, workers=[worker], pure=False)
        for worker, device in zip(workers, ["cpu", "gpu", "auto"])
    ]
    assert set(client.gather(jobs)) == {scene.render(camera, SIZE).digest()}


def test_a_worker_that_dies_changes_nothing(camera):
    scene = cloud(20_000, sky=dict(intensity=1))
    size = (400, 300)
    alone = scene.render(camera, size).rgb8
    cluster = LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, memory_limit=0
    )
    with cluster, Client(cluster) as client:
        array = kd.render(scene, camera, size, client=client, rows=15)
        future = client.compute(array)
        victim = list(client.run(os.getpid).values())[0]
        while not any(client.processing().values()):
            time.sleep(0.01)
        time.sleep(0.2)
        os.kill(victim, signal.SIGKILL)
        assert (future.result(timeout=120) == alone).all()
