"""A random agent on the Gymnasium environment: python examples/random_agent.py [DATA] [SPLIT]"""

import sys

import gymnasium

import arramon_client.environments  # noqa: F401 - registers the environments


def main(data: str = "arramon-data", split: str = "val_seen") -> None:
    """Play one episode with random actions, and print the scores."""
    env = gymnasium.make("arramon/ArraMon-v0", data=data, split=split, lang="hi", image_size=84)
    observation, info = env.reset(seed=0)
    env.action_space.seed(0)
    print("episode", info["episode_id"], "begins with:", observation["instruction"])
    terminated, steps = False, 0
    while not terminated:
        observation, _, terminated, _, info = env.step(env.action_space.sample())
        steps += 1
    print(f"{steps} steps, {info['cause']}, nDTW {info['scores']['total']['nDTW']:.3f}")
    env.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
