"""Do other programs see the same surface, the right way up, in what asperity writes, and asperity in what they write?

The surface has unequal sides and pitches, no symmetry and one bright corner (top left), so that a mirrored, turned or
transposed map cannot pass. Then every file of the shared collection that another reader can read.
"""

import os
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import gwyfile.objects
import h5py
import numpy as np
import OpenEXR
import surfalize
import SurfaceTopography
import tifffile
import x3pio
from PIL import Image

warnings.filterwarnings("ignore")

ASPERITY = os.environ["ASPERITY"]
SHARED = Path(os.environ["ASPERITY_SHARED"]) / "heightmaps"
ROWS, COLUMNS, PITCH = 23, 37, (0.4e-6, 0.9e-6)
METRES = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9}
failures = []


def asymmetric():
    row, column = np.mgrid[:ROWS, :COLUMNS]
    z = 1e-7 * np.sin(0.3 * column + 0.05 * row**2) + 2e-9 * column - 3e-9 * row
    z[0, 0] += 1e-6
    return z


def convert(source, target, *options):
    done = subprocess.run([ASPERITY, "convert", source, "-o", target, *options], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr.strip())


def asperity_reads(path, folder, *options):
    convert(path, folder / "read.npy", *options)
    return np.load(folder / "read.npy")


def report(what, expected, found, bound, pitch=None, wanted=PITCH):
    """Prints the largest difference; gaps must be the same. A constant offset counts."""
    expected, found = np.asarray(expected, float), np.ma.filled(np.ma.asarray(found, float), np.nan)
    if expected.shape != found.shape:
        verdict = f"shape {found.shape} instead of {expected.shape}"
    elif (np.isnan(expected) != np.isnan(found)).any():
        verdict = f"{np.isnan(found).sum()} points missing instead of {np.isnan(expected).sum()}"
    elif (difference := np.nanmax(np.abs(expected - found))) > bound:
        verdict = f"off by {difference:.2g} m, more than {bound:.2g} m"
    elif pitch is not None and not np.allclose(pitch, wanted, rtol=1e-6):
        verdict = f"pitch {pitch} instead of {wanted}"
    else:
        print(f"  ok      {what}: within {difference:.2g} m")
        return
    print(f"  FAILED  {what}: {verdict}")
    failures.append(what)


def by_surfalize(path):
    s = surfalize.Surface.load(path)
    return s.data * 1e-6, (s.step_x * 1e-6, s.step_y * 1e-6)


def by_surface_topography(path):
    t = SurfaceTopography.open_topography(str(path)).topography()
    unit = METRES[t.unit]
    # Its first index runs along x.
    heights = np.ma.filled(t.heights(), np.nan).T * unit
    return heights, tuple(np.array(t.physical_sizes) / t.nb_grid_pts * unit)


def by_x3pio(path):
    file = x3pio.read(path)
    # It keeps the offset of the height axis apart.
    heights = np.ma.filled(np.ma.asarray(file.layers[0].z), np.nan) + file.placement.offset[2]
    return heights, (file.header.x.increment, file.header.y.increment)


def what_asperity_writes(folder):
    print("what asperity writes, read by others")
    z = asymmetric()
    z[5, 7] = z[-1, -1] = np.nan
    np.save(folder / "z.npy", z)
    known = ("--unit", "m", "--pitch", "0.4um,0.9um")
    readers = [("surfalize", by_surfalize), ("SurfaceTopography", by_surface_topography), ("x3pio", by_x3pio)]
    half_step, f32 = 0.5 * 1.2e-6 / 65530, 2e-13
    for samples, bound in [("int16", half_step), ("f32", f32), ("f64", 1e-21)]:
        path = folder / f"{samples}.x3p"
        convert(folder / "z.npy", path, *known, "--samples", samples)
        for name, reader in readers:
            report(f"x3p {samples} by {name}", z, *_with_bound(reader(path), bound))
    for flag, name in [((), "binary"), (("--ascii",), "ASCII")]:
        path = folder / f"{name}.sdf"
        convert(folder / "z.npy", path, *known, *flag)
        for reader_name, reader in readers[:2]:
            try:
                found, pitch = reader(path)
            except Exception as error:  # their readers, their limits: said, not hidden
                print(f"  --      sdf {name}: {reader_name} does not read it ({type(error).__name__}: {error})")
                continue
            found = np.where(np.abs(found) > 1e3, np.nan, found)
            report(f"sdf {name} by {reader_name}", z, found, 1e-21, pitch)
    convert(folder / "z.npy", folder / "same.npy", *known)
    report("npy by numpy", z, np.load(folder / "same.npy"), 0)
    convert(folder / "z.npy", folder / "z.png", *known)
    picture = deep_png(folder / "z.png")
    low, high = (float(v) for v in Image.open(folder / "z.png").text["asperity:height_range_m"].split())
    heights = np.where(picture[..., 1] > 0, low + picture[..., 0] / 65535 * (high - low), np.nan)
    report("16-bit png by a plain decoder", z, heights, half_step)
    convert(folder / "z.npy", folder / "view.png", *known, "--preview")
    colours = np.asarray(Image.open(folder / "view.png").convert("RGB"), int)
    # The picture begins at (20, 36); its first cell is the bright corner, the last one is missing and grey.
    corner, beside = colours[40, 24], colours[40, 24 + 3 * (1000 - 40 - 132) // COLUMNS]
    print(f"  {'ok' if corner.sum() > beside.sum() + 100 else 'FAILED'}      colour preview: corner {corner}, beside it {beside}")
    if corner.sum() <= beside.sum() + 100:
        failures.append("preview")


def _with_bound(found, bound):
    return found[0], bound, found[1]


def deep_png(path):
    """Samples of a 16-bit grey and alpha PNG (Pillow keeps 8 bits of these); filters as the PNG specification has them."""
    import struct
    import zlib

    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", body[:10])
            assert (depth, colour) == (16, 4)
        packed += body if kind == b"IDAT" else b""
        at += 12 + length
    raw, stride = np.frombuffer(zlib.decompress(packed), np.uint8), 4 * width
    lines, above = [], np.zeros(stride, int)
    for line in raw.reshape(height, stride + 1).astype(int):
        kind, line = line[0], line[1:]
        for i in range(stride):
            left, upper = (line[i - 4] if i >= 4 else 0), above[i]
            corner = above[i - 4] if i >= 4 else 0
            nearest = min((left, upper, corner), key=lambda v: abs(left + upper - corner - v))
            line[i] = (line[i] + [0, left, upper, (left + upper) // 2, nearest][kind]) % 256
        lines.append(line)
        above = line
    return np.array(lines, np.uint8).reshape(height, width, 4).view(">u2").astype(float)


def what_others_write(folder):
    print("what others write, read by asperity")
    z = asymmetric()
    known = ("--unit", "m", "--pitch", "0.4um,0.9um")
    gaps = z.copy()
    gaps[5, 7] = np.nan
    read = lambda name, *options: asperity_reads(folder / name, folder, *options)

    np.save(folder / "c.npy", np.asfortranarray(gaps))
    report("npy of numpy, Fortran order", gaps, read("c.npy", *known), 0)
    np.save(folder / "b.npy", gaps.astype(">f4"))
    report("npy of numpy, big-endian f32", gaps, read("b.npy", *known), 1e-13)
    np.savez_compressed(folder / "z.npz", heights=gaps, other=np.zeros(3))
    report("npz of numpy", gaps, read("z.npz", *known), 0)
    np.savetxt(folder / "z.txt", gaps)
    report("text of numpy", gaps, read("z.txt", *known), 0)
    np.savetxt(folder / "z.csv", gaps, delimiter=",", header="made by hand")
    report("csv of numpy", gaps, read("z.csv", *known), 0)
    row, column = np.mgrid[:ROWS, :COLUMNS]
    xyz = np.column_stack([0.4e-6 * column.ravel(), 0.9e-6 * (ROWS - 1 - row).ravel(), gaps.ravel()])
    np.savetxt(folder / "z.xyz", xyz[~np.isnan(xyz[:, 2])])
    report("xyz of numpy, y up", gaps, read("z.xyz", "--unit", "m"), 0)
    for name, options in [("plain", {}), ("deflate", {"compression": "zlib"}), ("tiles", {"tile": (16, 16)})]:
        tifffile.imwrite(folder / f"{name}.tif", gaps.astype(np.float32), **options)
        report(f"float tiff of tifffile, {name}", gaps, read(f"{name}.tif", *known), 1e-13)
    levels = np.round((z - z.min()) / np.ptp(z) * 65535).astype(np.uint16)
    Image.fromarray(levels).save(folder / "levels.png")
    found = read("levels.png", "--pitch", "0.4um,0.9um", "--height-range", f"{z.min()}m,{z.max()}m")
    report("16-bit png of Pillow", z, found, 0.51 * np.ptp(z) / 65535)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"Z": gaps.astype(np.float32)}).write(str(folder / "z.exr"))
    report("exr of OpenEXR", gaps, read("z.exr", *known), 1e-13)
    for kind in x3pio.DataStorage:
        x3pio.write(folder / "o.x3p", gaps, x_scale=PITCH[0], y_scale=PITCH[1], storage=kind)
        report(f"x3p of x3pio, {kind.name}", gaps, read("o.x3p"), 1e-21)
    for ending in ("sur", "sdf", "x3p"):
        try:
            surfalize.Surface(z * 1e6, PITCH[0] * 1e6, PITCH[1] * 1e6).save(folder / f"s.{ending}")
        except Exception as error:
            print(f"  --      surfalize does not write {ending} ({error})")
            continue
        report(f"{ending} of surfalize", z, read(f"s.{ending}"), 1e-13)
    field = gwyfile.objects.GwyDataField(z, xreal=COLUMNS * PITCH[0], yreal=ROWS * PITCH[1], si_unit_xy="m", si_unit_z="m")
    container = gwyfile.objects.GwyContainer()
    container["/0/data"] = field
    container.tofile(str(folder / "z.gwy"))
    report("gwy of gwyfile", z, read("z.gwy"), 0)
    with h5py.File(folder / "z.datx", "w") as file:
        surface = file.create_dataset("Data/Surface/{1}", data=gaps * 1e9, chunks=(8, 8), compression="gzip", shuffle=True)
        surface.attrs["Unit"] = np.array(["NanoMeters"], dtype=h5py.string_dtype())
    report("datx of h5py, no pitch in it", gaps, read("z.datx", "--pitch", "0.4um,0.9um"), 1e-20)


# Where another reader is known to be wrong: not an oracle for that file.
KNOWN = {
    ("surfalize", "plu-1.plu"): "starts 8 bytes early",
    ("surfalize", "valid_zygo_dat_file.dat"): "takes the phase resolution for the next one",
    ("SurfaceTopography", "nms-1.nms"): "takes nm for mm in the pitch, and 65534 for the 65535 steps of the heights",
    ("surfalize", "nms-1.nms"): "takes 65534 for the 65535 steps: its highest point lies above the zmax of the file",
}


def real_files(folder):
    print("real files, heights less their mean")
    if not SHARED.is_dir():
        print(f"  --      SKIPPED: {SHARED} is absent; set ASPERITY_SHARED")
        return
    readers = [("SurfaceTopography", by_surface_topography), ("surfalize", by_surfalize), ("x3pio", by_x3pio)]
    for path in sorted([*SHARED.glob("real/*"), *SHARED.glob("converted/*")]):
        own = asperity_reads(path, folder)
        convert(path, folder / "own.x3p")
        pitch = by_x3pio(folder / "own.x3p")[1]
        # The last places of f32 at the height the map is stored at, and of i32 in a float.
        bound = 2e-6 * np.nanmax(np.abs(own - np.nanmean(own))) + 2.0**-23 * np.nanmax(np.abs(own))
        for name, reader in readers:
            if reader is by_x3pio and path.suffix != ".x3p":
                continue
            try:
                found, other = reader(path)
            except Exception as error:
                print(f"  --      {path.name}: {name} does not read it ({type(error).__name__})")
                continue
            if (name, path.name) in KNOWN:
                print(f"  --      {path.name}: {name} {KNOWN[name, path.name]}")
                continue
            found = np.ma.filled(np.ma.asarray(found, float), np.nan)
            level = lambda a: a - np.nanmean(a)
            report(f"{path.name} by {name}", level(own), level(found), bound, other, pitch)


with tempfile.TemporaryDirectory() as temporary:
    what_asperity_writes(Path(temporary))
    what_others_write(Path(temporary))
    real_files(Path(temporary))
if failures:
    sys.exit(f"{len(failures)} comparisons failed: {', '.join(failures)}")
print("all agree")
