"""Pictures that are drawn again equal the frames that the agent got, byte for byte."""

from contextlib import closing
from pathlib import Path

import grpc
import numpy as np
import simplejpeg

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_server.playback.moments import Playback
from arramon_server.playback.pictures import as_jpeg, draw
from arramon_server.runs.play.worlds import Worlds
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.sim.footprints import Footprints
from arramon_server.sim.rules import Limits
from tests import tiny
from tests.api.player import Player, create
from tests.serving import Server

SIZE = 224


def test_frames_are_those_of_the_agent(tmp_path: Path) -> None:
    split = tiny.write(tmp_path, count=1)
    server = Server(tmp_path)
    with grpc.insecure_channel(server.address) as channel:
        stub = EvaluationStub(channel)
        run = create(stub, sensors=["rgb"])
        got: list[bytes] = []
        with Player(stub, run.run_id, image_size=SIZE, encoding=types_pb2.ENCODING_RAW) as player:
            while (event := player.next()).WhichOneof("event") != "run_ended":
                if event.WhichOneof("event") == "observation":
                    seen: pb.Observation = event.observation
                    got.append(bytes(seen.rgb.data))
                    player.act(seen.episode_id, seen.step, int(tiny.ACTIONS[seen.step]))
    assert server.stop() == 0
    with closing(Database(f"sqlite:///{tmp_path / 'journal.db'}")) as database:
        actions = Journal(database).actions(run.run_id, "0")
    with closing(Worlds({split.name: split}, physics=Footprints)) as worlds:
        world = worlds.world(split.name, split.episodes["0"])
        playback = Playback(split.episodes["0"], world, Limits())
        playback.extend(actions)
        again = [draw(world, moment.state, SIZE).tobytes() for moment in playback.moments[:-1]]
        assert len(got) == len(tiny.ACTIONS)
        assert again == got
        others = [draw(world, playback.moment(0).state, SIZE, kind) for kind in ("depth", "segmentation")]
    assert [picture.shape for picture in others] == [(SIZE, SIZE, 3)] * 2
    assert all(len(np.unique(picture.reshape(-1, 3), axis=0)) > 3 for picture in others)
    assert simplejpeg.decode_jpeg(as_jpeg(others[0])).shape == (SIZE, SIZE, 3)
