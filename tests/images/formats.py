"""One image, written by other programs in every format, must give one and the same slice.

    formats.py MOULAGE

SimpleITK writes NIfTI, NRRD and MetaImage, pydicom writes DICOM series (explicit, implicit, big-endian,
RLE); the grid is oblique, anisotropic and left-handed. Each slice drawn by moulage is compared with
SimpleITK's own resampling, so that a mirrored side would show.
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import pydicom
import SimpleITK as sitk
from PIL import Image
from pydicom.dataset import FileDataset, FileMetaDataset
from pydicom.uid import (
    CTImageStorage,
    ExplicitVRBigEndian,
    ExplicitVRLittleEndian,
    ImplicitVRLittleEndian,
    RLELossless,
    generate_uid,
)

SIZE = (40, 31, 22)
SPACING = (1.3, 2.0, 2.5)
ORIGIN = (-31.0, 17.0, -420.0)  # LPS
WINDOW = (1500, 400)


def directions():
    """Columns: the index axes in LPS; the third one is turned, which makes the grid left-handed."""
    a, b = np.radians(17), np.radians(-9)
    turn_z = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    turn_x = np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    return turn_z @ turn_x @ np.diag([1.0, 1.0, -1.0])


def make_image():
    """Values that no mirroring leaves as they are."""
    k, j, i = np.meshgrid(*(np.arange(n) for n in reversed(SIZE)), indexing="ij")
    values = 20 * i - 11 * j + 7 * k + 300 * np.exp(-((i - 28) ** 2 + (j - 9) ** 2 + (k - 6) ** 2) / 40)
    image = sitk.GetImageFromArray(values.astype(np.int16))
    image.SetSpacing(SPACING)
    image.SetOrigin(ORIGIN)
    image.SetDirection(directions().flatten().tolist())
    return image


def write_dicom(image, folder, syntax):
    """One file per slice, in an order that says nothing; values are stored with slope and intercept."""
    folder.mkdir()
    values = sitk.GetArrayFromImage(image)
    series, study, place = generate_uid(), generate_uid(), generate_uid()
    across, down = directions()[:, 0], directions()[:, 1]
    for k, plane in enumerate(values):
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID = CTImageStorage
        meta.MediaStorageSOPInstanceUID = generate_uid()
        native = syntax in (ExplicitVRLittleEndian, ImplicitVRLittleEndian, ExplicitVRBigEndian)
        meta.TransferSyntaxUID = syntax if native else ExplicitVRLittleEndian
        path = folder / f"{(k * 7) % SIZE[2]:03}.dcm"
        data = FileDataset(str(path), {}, file_meta=meta, preamble=b"\0" * 128)
        data.SOPClassUID = CTImageStorage
        data.SOPInstanceUID = meta.MediaStorageSOPInstanceUID
        data.SeriesInstanceUID, data.StudyInstanceUID, data.FrameOfReferenceUID = series, study, place
        data.Modality, data.PatientName, data.PatientID = "CT", "None^Test", "0"
        data.ImageOrientationPatient = [f"{x:.10f}"[:16] for x in (*across, *down)]
        corner = image.TransformIndexToPhysicalPoint((0, 0, k))
        data.ImagePositionPatient = [f"{x:.10f}"[:16] for x in corner]
        data.PixelSpacing = [SPACING[1], SPACING[0]]
        data.SliceThickness = SPACING[2]
        data.Rows, data.Columns = plane.shape
        data.SamplesPerPixel, data.PhotometricInterpretation = 1, "MONOCHROME2"
        data.BitsAllocated, data.BitsStored, data.HighBit, data.PixelRepresentation = 16, 16, 15, 0
        data.RescaleSlope, data.RescaleIntercept = 0.5, -1024
        stored = ((plane.astype(np.int32) + 1024) * 2).astype(np.uint16)
        big = syntax == ExplicitVRBigEndian
        data.PixelData = stored.astype(">u2" if big else "<u2").tobytes()
        data["PixelData"].VR = "OW"
        if not native:
            data.compress(syntax)
        pydicom.dcmwrite(path, data, enforce_file_format=True)


def expected(image, axis, position, pixel):
    """The slice as SimpleITK sees it: pixels of `pixel` mm, seen as a radiologist does."""
    corners = []
    for i in (-0.5, SIZE[0] - 0.5):
        for j in (-0.5, SIZE[1] - 0.5):
            for k in (-0.5, SIZE[2] - 0.5):
                lps = np.array(image.TransformContinuousIndexToPhysicalPoint((i, j, k)))
                corners.append(lps * (-1, -1, 1))
    corners = np.array(corners)
    right, down = {"axial": ((-1, 0, 0), (0, -1, 0)), "coronal": ((-1, 0, 0), (0, 0, -1)),
                   "sagittal": ((0, -1, 0), (0, 0, -1))}[axis]
    right, down = np.array(right), np.array(down)
    ahead = {"axial": np.array((0, 0, 1)), "coronal": np.array((0, 1, 0)), "sagittal": np.array((1, 0, 0))}[axis]
    spans = [(corners @ d).min() for d in (right, down)]
    width, height = (round(np.ptp(corners @ d) / pixel) for d in (right, down))
    first = right * (spans[0] + pixel / 2) + down * (spans[1] + pixel / 2) + ahead * position
    reference = sitk.Image(width, height, 1, sitk.sitkFloat32)
    lps = np.array((-1, -1, 1))
    reference.SetOrigin((first * lps).tolist())
    reference.SetSpacing((pixel, pixel, 1))
    normal = np.cross(right * lps, down * lps)
    reference.SetDirection(np.column_stack((right * lps, down * lps, normal)).flatten().tolist())
    floats = sitk.Cast(image, sitk.sitkFloat32)
    seen = sitk.GetArrayFromImage(sitk.Resample(floats, reference, defaultPixelValue=-1e9))[0]
    grey = np.clip((seen - (WINDOW[1] - WINDOW[0] / 2)) / WINDOW[0] * 255, 0, 255)
    return grey, seen > -1e8


def main():
    moulage = sys.argv[1]
    image = make_image()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        paths = []
        for name in ("a.nii", "a.nii.gz", "a.nrrd", "a.nhdr", "a.mha", "a.mhd"):
            sitk.WriteImage(image, str(folder / name))
            paths.append(folder / name)
        sitk.WriteImage(image, str(folder / "packed.mha"), useCompression=True)
        sitk.WriteImage(image, str(folder / "packed.nrrd"), useCompression=True)
        paths += [folder / "packed.mha", folder / "packed.nrrd"]
        for name, syntax in (("explicit", ExplicitVRLittleEndian), ("implicit", ImplicitVRLittleEndian),
                             ("big", ExplicitVRBigEndian), ("rle", RLELossless)):
            write_dicom(image, folder / name, syntax)
            paths.append(folder / name)
        for axis, position in (("axial", -440.0), ("coronal", -38.0), ("sagittal", 5.0)):
            wanted, inside = expected(image, axis, position, 0.7)
            for path in paths:
                out = folder / "slice.png"
                subprocess.run([moulage, "slice", path, "--plane", axis, "--at", str(position), "--pixel", "0.7",
                                "--window", f"{WINDOW[0]},{WINDOW[1]}", "-o", out],
                               check=True, capture_output=True)
                seen = np.asarray(Image.open(out)).astype(float)
                assert seen.shape[:2] == wanted.shape, (path, seen.shape, wanted.shape)
                plain = (seen[..., 0] == seen[..., 2]) & inside  # the letters of the sides are coloured
                off = np.abs(seen[..., 0] - wanted)[plain]
                assert inside.sum() > 500 and off.max() < 2, f"{path.name}, {axis}: {off.max()}"
            print(f"{axis}: {len(paths)} files agree with SimpleITK within {off.max():.2f} of 255 grey values")


if __name__ == "__main__":
    main()
