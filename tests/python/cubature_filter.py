"""Tracks one thing by bearings with filterpy's cubature Kalman filter, alone and range-parameterized.

Usage: cubature_filter.py < scenarios.json > estimates.json

A list of scenarios, each: "settings" (members, velocity_std, acceleration_density, min_range_meters,
max_range_meters, deviation_radians), "alone" (mean, covariance) and "sights", a list of [seconds, east, north,
bearing]. The first sight begins the range-parameterized filter; both filters take in all others. The
estimates: for each scenario and each of those others what "alone" and "mixture" hold after it, and the
mixture's "weights".

filterpy moves its points through the motion and uses the same points for the measurement, without the process
noise. Arasaratnam and Haykin draw them anew from the predicted distribution, so that is done here before each
update. Bearings are told as differences from the bearing of the mean, since a bearing has no order across pi.
"""

import json
import sys
from math import atan2, exp, log, pi, sqrt, tau

import numpy as np
from filterpy.common import Q_continuous_white_noise
from filterpy.kalman import CubatureKalmanFilter
from filterpy.kalman.CubatureKalmanFilter import spherical_radial_sigmas

LEAST_WEIGHT = 1e-3


def wrapped(angle):
    return (angle + pi) % tau - pi


def bearing(state, observer):
    return atan2(state[1] - observer[1], state[0] - observer[0])


def moved(state, seconds):
    x, y, east, north = state
    return np.array([x + seconds * east, y + seconds * north, east, north])


def relative_bearing(state, observer, center):
    return np.array([wrapped(bearing(state, observer) - center)])


def make_filter(mean, covariance, settings):
    kalman = CubatureKalmanFilter(dim_x=4, dim_z=1, dt=1.0, hx=relative_bearing, fx=moved)
    kalman.x = np.array(mean, dtype=float)[:, None]
    kalman.P = np.array(covariance, dtype=float)
    kalman.R = np.array([[settings["deviation_radians"] ** 2]])
    return kalman


def step(kalman, seconds, observer, seen, settings):
    """Returns the logarithm of the bearing's density."""
    density = settings["acceleration_density"]
    kalman.Q = Q_continuous_white_noise(2, seconds, density, block_size=2, order_by_dim=False)
    kalman.predict(dt=seconds)
    kalman.sigmas_f = spherical_radial_sigmas(kalman.x, kalman.P)
    center = bearing(kalman.x.flatten(), observer)
    kalman.update(np.array([[wrapped(seen - center)]]), hx_args=(observer, center))
    innovation, variance = kalman.y.item(), kalman.S.item()
    return -0.5 * (innovation**2 / variance + log(tau * variance))


def born(observer, seen, settings):
    nearest, members = settings["min_range_meters"], settings["members"]
    rho = (settings["max_range_meters"] / nearest) ** (1 / members)
    along = np.array([np.cos(seen), np.sin(seen)])
    across = np.array([-along[1], along[0]])
    mixture = []
    for part in range(1, members + 1):
        distance = nearest * (rho**part + rho ** (part - 1)) / 2
        deviation = distance * 2 * (rho - 1) / ((rho + 1) * sqrt(12))
        covariance = np.diag([settings["velocity_std"] ** 2] * 4)
        covariance[:2, :2] = deviation**2 * np.outer(along, along)
        covariance[:2, :2] += (distance * settings["deviation_radians"]) ** 2 * np.outer(across, across)
        mean = [*(np.array(observer) + distance * along), 0, 0]
        mixture.append([1 / members, make_filter(mean, covariance, settings)])
    return mixture


def step_mixture(mixture, *sight):
    densities = [step(kalman, *sight) for _, kalman in mixture]
    likelihoods = [exp(density - max(densities)) for density in densities]
    weighed = [[weight * likelihood, kalman] for (weight, kalman), likelihood in zip(mixture, likelihoods)]
    total = sum(weight for weight, _ in weighed)
    kept = [[weight / total, kalman] for weight, kalman in weighed if weight / total >= LEAST_WEIGHT]
    total = sum(weight for weight, _ in kept)
    return [[weight / total, kalman] for weight, kalman in kept]


def moments(mixture):
    mean = sum(weight * kalman.x.flatten() for weight, kalman in mixture)
    covariance = np.zeros((4, 4))
    for weight, kalman in mixture:
        offset = kalman.x.flatten() - mean
        covariance += weight * (kalman.P + np.outer(offset, offset))
    return {"mean": mean.tolist(), "covariance": covariance.tolist()}


def track(scenario):
    settings, sights = scenario["settings"], scenario["sights"]
    alone = make_filter(scenario["alone"]["mean"], scenario["alone"]["covariance"], settings)
    before, *first = sights[0]
    mixture = born(first[:2], first[2], settings)
    estimates = []
    for seconds, east, north, seen in sights[1:]:
        sight = (seconds - before, (east, north), seen, settings)
        before = seconds
        step(alone, *sight)
        mixture = step_mixture(mixture, *sight)
        weights = [weight for weight, _ in mixture]
        estimates.append({"alone": moments([[1, alone]]), "mixture": moments(mixture), "weights": weights})
    return estimates


if __name__ == "__main__":
    json.dump([track(scenario) for scenario in json.load(sys.stdin)], sys.stdout)
