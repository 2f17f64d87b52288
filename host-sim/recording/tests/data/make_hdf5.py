"""Writes classic.h5, latest.h5 and matlab73.mat with h5py 3: python make_hdf5.py

classic.h5 and latest.h5 are what h5py makes by default and of the newest format. matlab73.mat is laid out as MATLAB lays out
version 7.3: a block of 512 bytes before the HDF5 file, column vectors as matrices of one row, the class of each as an attribute.
"""

import h5py
import numpy as np

ROWS = 60
t = 0.001 * np.arange(ROWS)
angle = 30 * np.sin(5 * t)
current = np.cos(5 * t).astype("f4")
counts = np.round(1000 * angle).astype("i4")


def fill(file):
    packed = {"compression": "gzip", "shuffle": True}
    file["t"] = t
    motor = file.create_group("motor")
    motor.create_dataset("angle_deg", data=angle, chunks=(32,), fletcher32=True, **packed)
    motor.create_dataset("current", data=current, chunks=(25,), maxshape=(None,), **packed)
    motor["counts"] = counts.astype(">i4")
    motor["enabled"] = t > 0.01
    motor["pair"] = np.stack([angle, t], axis=1)
    motor["comment"] = "step 3"
    row = np.dtype([("t", "f8"), ("name", "S4"), ("torque", "f4")])
    table = np.zeros(ROWS, row)
    table["t"], table["torque"] = t, current
    file.create_dataset("table", data=table, chunks=(16,), **packed)


with h5py.File("classic.h5", "w") as file:
    fill(file)
with h5py.File("latest.h5", "w", libver="latest") as file:
    fill(file)

with h5py.File("matlab73.mat", "w", userblock_size=512) as file:

    def put(group, name, values, kind, **more):
        group.create_dataset(name, data=values, **more).attrs["MATLAB_class"] = np.bytes_(kind)

    put(file, "t", t[None, :], "double", chunks=(1, 32), compression="gzip", compression_opts=3)
    run = file.create_group("run")
    run.attrs["MATLAB_class"] = np.bytes_("struct")
    put(run, "angle_deg", angle[None, :], "double")
    put(run, "current", current[None, :], "single", chunks=(1, 32), compression="gzip", compression_opts=3)
    put(run, "log", np.stack([angle, t]), "double")
    put(run, "enabled", (t > 0.01)[None, :].astype("u1"), "logical")
    put(file, "comment", np.frombuffer("step 3".encode("utf-16-le"), "u2")[:, None], "char")
    put(file, "none", np.array([0, 0], "u8"), "double")
    file["none"].attrs["MATLAB_empty"] = np.uint8(1)
    put(file, "T", np.zeros((1, 6), "u4"), "timetable")
    file["T"].attrs["MATLAB_object_decode"] = np.int32(3)
    file.create_group("#refs#")["a"] = t[None, :]

head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Jan  1 00:00:00 2024 HDF5 schema 1.00 ."
with open("matlab73.mat", "r+b") as file:
    file.write(head.ljust(116, b" ") + b"\0" * 8 + b"\0\x02IM")
