#!/usr/bin/env python3
# Scores of a rendered crowd and of small silhouettes by tools that share no code with this project: writes expected.json
# from the pictures beside it. Not run by any test; Debian 12's packages python3-numpy, python3-scipy, python3-skimage,
# python3-pil and python3-openimageio are what it was run with. Lists of rows are top to bottom.
#
# What each number is made by:
#   silhouette_iou            1 - scipy.spatial.distance.jaccard
#   silhouette_difference_px  scipy.spatial.distance.hamming, times the pixels
#   boundary_px_*, hausdorff  scipy.ndimage.binary_erosion for the boundary, scipy.ndimage.distance_transform_edt for the
#                             distances; checked here against scipy.spatial.cKDTree and directed_hausdorff
#   holes, strays             scipy.ndimage.binary_erosion and binary_dilation
#   depth_mae                 scipy.ndimage.mean with the ids as labels
#   ssim_union                skimage.metrics.structural_similarity (its map)
#   mae, mse, psnr            NumPy; skimage.metrics.mean_squared_error and peak_signal_noise_ratio
#   linear_mae, linear_rms    NumPy; skimage.metrics.mean_squared_error
#   flicker                   numpy.diff, of skimage.color.rgb2yuv's luma
import json
import os

import numpy
import OpenImageIO
import PIL
import PIL.Image
import scipy
import scipy.ndimage
import scipy.spatial
import scipy.spatial.distance
import skimage
import skimage.color
import skimage.metrics

HERE = os.path.dirname(os.path.abspath(__file__))
TICKS = [0, 2, 4, 6, 8]
FRAME = 4
CROSS = scipy.ndimage.generate_binary_structure(2, 1)
SQUARE = scipy.ndimage.generate_binary_structure(2, 2)

# Silhouettes small enough to be read: '.' is nothing, a digit an agent's id.
GRIDS = {
    "nothing in either": (["......"] * 4, ["......"] * 4),
    "nothing in the test": (
        ["........", "..1111..", "..1111..", "..1111..", "..11....", "........"],
        ["........"] * 6),
    "nothing in the reference": (
        ["........"] * 6,
        ["........", "..1111..", "..1111..", "..1111..", "..11....", "........"]),
    "one pixel each, apart": (
        ["........", ".1......", "........", "........", "........", "........"],
        ["........", "........", "........", "........", "........", ".....1.."]),
    "one pixel in opposite corners": (
        ["1.......", "........", "........", "........", "........"],
        ["........", "........", "........", "........", ".......1"]),
    "all of the picture, both": (["11111"] * 4, ["11111"] * 4),
    "all of the picture, and half of it": (["111111"] * 4, ["111..."] * 4),
    "cut off by the left and upper edge": (
        ["11111...", "11111...", "1111....", "1111....", "11......", "........"],
        ["1111....", "1.111...", "1111....", "11.1..1.", "111.....", "........"]),
    "a ring, and a disc with an arm": (
        [".........", "...111...", "..11111..", ".111.111.", ".11...11.", ".111.111.", "..11111..", "...111...", "........."],
        [".........", "...111...", "..11111..", ".1111111.", ".11111111", ".1111111.", "..11111..", "...111...", "........."]),
    "as thin as a pixel": (
        ["..........", ".11111111.", "..........", "..........", ".........."],
        ["..........", "..........", "....1.....", ".11111111.", ".........."]),
    "two agents that change places": (
        ["..........", ".1112222..", ".1112222..", ".1112222..", ".111..22..", "..........", ".......3.."],
        ["..........", ".2222111..", ".2222111..", ".2222111..", ".22..111..", "..........", ".......3.."]),
    "one agent over another, and one that is gone": (
        ["............", ".11111..33..", ".111112233..", ".1111122....", ".1111122....", "...2222222..", "...2222222.."],
        ["............", ".11111......", ".112222.....", ".112222.....", ".1112222....", "...2222222..", "...2222224.."]),
}


def grid(rows):
    return numpy.array([[0 if c == "." else int(c) for c in row] for row in rows])


def boundary(mask):
    return mask & ~scipy.ndimage.binary_erosion(mask, CROSS, border_value=1)


def distances(a, b):
    """From every boundary pixel of either to the nearest of the other."""
    a, b = boundary(a), boundary(b)
    if not a.any() or not b.any():
        return None
    found = numpy.concatenate([scipy.ndimage.distance_transform_edt(~b)[a], scipy.ndimage.distance_transform_edt(~a)[b]])
    p, q = numpy.argwhere(a), numpy.argwhere(b)
    by_tree = numpy.concatenate([scipy.spatial.cKDTree(q).query(p)[0], scipy.spatial.cKDTree(p).query(q)[0]])
    assert numpy.allclose(found, by_tree, atol=1e-9)
    hausdorff = max(scipy.spatial.distance.directed_hausdorff(p, q)[0],
                    scipy.spatial.distance.directed_hausdorff(q, p)[0])
    assert abs(hausdorff - found.max()) < 1e-9
    return found


def silhouette_scores(a, b, of_agent):
    out = {"silhouette_iou": None, "silhouette_hausdorff_px": None, "holes": None, "strays": None}
    if a.any() or b.any():
        out["silhouette_iou"] = 1 - scipy.spatial.distance.jaccard(a.ravel(), b.ravel())
    out["silhouette_difference_px"] = scipy.spatial.distance.hamming(a.ravel(), b.ravel()) * a.size
    found = distances(a, b)
    if found is not None:
        out["silhouette_hausdorff_px"] = found.max()
    if not of_agent:
        out["boundary_px_mean"] = None if found is None else found.mean()
        out["boundary_px_p95"] = None if found is None else numpy.percentile(found, 95)
    if a.any():
        inside = scipy.ndimage.binary_erosion(a, SQUARE, border_value=1)
        near = scipy.ndimage.binary_dilation(a, SQUARE)
        out["holes"] = 1000 * (inside & ~b).sum() / a.sum()
        out["strays"] = 1000 * (b & ~near).sum() / a.sum()
    return out


def code_scores(a, b, mask):
    """Over the pixels of a mask."""
    p, q = a[mask].astype(float), b[mask].astype(float)
    equal = numpy.array_equal(p, q)
    return {"mae": numpy.abs(p - q).mean(),
            "mse": skimage.metrics.mean_squared_error(p, q),
            "psnr": "inf" if equal else skimage.metrics.peak_signal_noise_ratio(p, q, data_range=255)}


def luma(rgb):
    return skimage.color.rgb2yuv(rgb)[..., 0] * 255


def ssim_map(a, b):
    """NaN where the window reaches over the edge."""
    values = skimage.metrics.structural_similarity(luma(a), luma(b), gaussian_weights=True, sigma=1.5,
                                                   use_sample_covariance=False, data_range=255, full=True)[1]
    out = numpy.full(values.shape, numpy.nan)
    out[5:-5, 5:-5] = values[5:-5, 5:-5]
    return out


def mean_or_none(values):
    values = values[~numpy.isnan(values)]
    return values.mean() if values.size else None


def read_picture(side, tick):
    return numpy.asarray(PIL.Image.open(os.path.join(HERE, f"{side}_{tick}.png")).convert("RGB"))


def read_exr(path):
    return OpenImageIO.ImageBuf(path).get_pixels(OpenImageIO.FLOAT)


def read_ids(side, tick):
    # Whole numbers of 32 bits come back as fractions of 2^32, which is exact for so few agents.
    return numpy.rint(read_exr(os.path.join(HERE, f"{side}_ids_{tick}.exr"))[..., 0] * 2.0**32).astype(int)


def crowd():
    a, b = read_picture("ref", FRAME), read_picture("test", FRAME)
    ids_a, ids_b = read_ids("ref", FRAME), read_ids("test", FRAME)
    depth = [read_exr(os.path.join(HERE, f"{side}_depth_{FRAME}.exr"))[..., 0].astype(float) for side in ("ref", "test")]
    same = (ids_a == ids_b) & (ids_a != 0)
    error = numpy.zeros(same.shape)
    error[same] = numpy.abs(depth[1][same] - depth[0][same])
    ssim = ssim_map(a, b)
    union = (ids_a != 0) | (ids_b != 0)
    whole = silhouette_scores(ids_a != 0, ids_b != 0, False)
    whole.update(code_scores(a, b, union))
    whole["ssim_union"] = mean_or_none(ssim[union])
    whole["depth_mae"] = scipy.ndimage.mean(error, same, 1)
    agents = {}
    for agent in sorted((set(ids_a[union]) | set(ids_b[union])) - {0}):
        in_a, in_b = ids_a == agent, ids_b == agent
        row = silhouette_scores(in_a, in_b, True)
        row.update(code_scores(a, b, in_a | in_b))
        row["ssim_union"] = mean_or_none(ssim[in_a | in_b])
        row["depth_mae"] = scipy.ndimage.mean(error, ids_a * same, agent) if (in_a & in_b).any() else None
        agents[str(agent)] = row
    return {"frame": FRAME, "region": "either silhouette", "scores": whole, "agents": agents}


def clip():
    error = numpy.stack([luma(read_picture("test", t)) - luma(read_picture("ref", t)) for t in TICKS])
    drawn = numpy.stack([(read_ids("ref", t) != 0) | (read_ids("test", t) != 0) for t in TICKS])
    change = numpy.abs(numpy.diff(error, n=2, axis=0))
    counted = drawn[:-2] | drawn[1:-1] | drawn[2:]
    return {"frames": TICKS,
            "in_region": {"value": change[counted].mean(), "by_frame": [c[m].mean() for c, m in zip(change, counted)]},
            "whole": {"value": change.mean(), "by_frame": [c.mean() for c in change]}}


def linear():
    """A picture in linear light, and one that differs by a formula in every value."""
    a = read_exr(os.path.join(HERE, "..", "hdr", "h03_half_exposure_ref.exr"))[..., :3].astype(numpy.float32)
    index = numpy.arange(a.size, dtype=numpy.int64).reshape(a.shape)
    b = a + (index * 7919 % 64 - 24).astype(numpy.float32) / numpy.float32(128)
    p, q = a.astype(float), b.astype(float)
    return {"reference": "hdr/h03_half_exposure_ref.exr", "test": "value[i] + (i * 7919 % 64 - 24) / 128",
            "scores": {"linear_mae": numpy.abs(p - q).mean(),
                       "linear_rms": numpy.sqrt(skimage.metrics.mean_squared_error(p, q))}}


def grids():
    out = []
    for name, (reference, test) in GRIDS.items():
        a, b = grid(reference), grid(test)
        assert a.shape == b.shape, name
        agents = {}
        for agent in sorted((set(a.ravel()) | set(b.ravel())) - {0}):
            agents[str(agent)] = silhouette_scores(a == agent, b == agent, True)
        text = [["".join("." if v == 0 else str(v) for v in row) for row in ids] for ids in (a, b)]
        out.append({"name": name, "reference": text[0], "test": text[1],
                    "scores": silhouette_scores(a != 0, b != 0, False), "agents": agents})
    return out


def plain(value):
    """NumPy's numbers as JSON's."""
    if isinstance(value, dict):
        return {key: plain(of) for key, of in value.items()}
    if isinstance(value, list):
        return [plain(of) for of in value]
    return float(value) if isinstance(value, numpy.generic) else value


def main():
    expected = {
        "tools": {"numpy": numpy.__version__, "scipy": scipy.__version__, "scikit-image": skimage.__version__,
                  "Pillow": PIL.__version__, "OpenImageIO": OpenImageIO.VERSION_STRING},
        "tolerances": {"default": 1e-9, "boundary_px_mean": 1e-5, "boundary_px_p95": 1e-5, "silhouette_hausdorff_px": 1e-5,
                       "ssim_union": 1e-6},
        "crowd": crowd(), "clip": clip(), "linear": linear(), "grids": grids()}
    with open(os.path.join(HERE, "expected.json"), "w") as file:
        json.dump(plain(expected), file, indent=1, allow_nan=False)
        file.write("\n")


main()
