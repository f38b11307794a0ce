"""A camera that looks at a folder of pictures."""

from pathlib import Path

from calib import Picture
from station.errors import InputUnusable
from station.pictures import pictures_of, read_picture

_REMEMBERED = 128  # pictures; a 2 Mpx one is decoded in 15 ms, too slow for 53 a second


class PictureFolder:
    """Serves the pictures of a folder in natural order, over and over; grey, of one size."""

    def __init__(self, path: Path) -> None:
        """Look at the folder.

        Raises
        ------
        InputUnusable
            If there is no such folder, no picture in it, or the first is no picture.
        """
        if not path.is_dir():
            raise InputUnusable(
                f"{path}: no folder; give a folder of PNG, JPEG, TIFF or BMP pictures of one size"
            )
        self._paths = pictures_of(path)
        self._pictures: dict[int, Picture] = {}
        self.height, self.width = read_picture(self._paths[0]).shape
        for place in range(min(_REMEMBERED, len(self._paths))):
            self._pictures[place] = self._read(place)

    def __len__(self) -> int:
        return len(self._paths)

    def frame(self, index: int, exposure_us: float) -> Picture:
        place = index % len(self._paths)
        remembered = self._pictures.get(place)
        return self._read(place) if remembered is None else remembered

    def _read(self, place: int) -> Picture:
        path = self._paths[place]
        picture = read_picture(path)
        if picture.shape != (self.height, self.width):
            raise InputUnusable(
                f"{path}: {picture.shape[1]} × {picture.shape[0]} px; a camera's pictures have "
                f"one size, and {self._paths[0].name} has {self.width} × {self.height}"
            )
        return picture
