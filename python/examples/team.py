"""A team on a bad network, one robot of which crashes: every robot follows our greedy policy on what it believes.

Usage: python team.py [SCENARIO]
"""

import sys
from pathlib import Path

import dragnet

SCENARIO = Path(__file__).resolve().parents[2] / "scenarios/faults.toml"


def main(scenario=SCENARIO, seed=0):
    env = dragnet.parallel_env(scenario, control="waypoint", crashes={3: 300.0})
    policies = {
        agent: dragnet.Policy("greedy", env.scenario, seed=seed, robot=number)
        for number, agent in enumerate(env.possible_agents, start=1)
    }
    observations, infos = env.reset(seed=seed)
    while env.agents:
        waypoints = {agent: policies[agent](env.belief(agent)).waypoint for agent in env.agents}
        observations, rewards, terminated, truncated, infos = env.step(waypoints)
        for agent in set(observations) - set(env.agents):
            print(f"{infos[agent]['time_seconds']:6.0f} s: {agent} is out: {infos[agent]['termination_reason']}")
    (last,) = {info["recall"] for info in infos.values()}
    print(f"recall of the team: {last:.2f}")
    return last


if __name__ == "__main__":
    main(*sys.argv[1:])
