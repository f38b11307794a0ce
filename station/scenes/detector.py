"""From light on the sensor to an 8-bit picture: shot noise, read noise, saturation, rounding."""

from dataclasses import dataclass

import cv2
import numpy as np

from calib import Picture
from station.scenes.patch import Counts


@dataclass(frozen=True, slots=True)
class Detector:
    """The sensor chip behind its converter; the figures are those of a CMV2000 at unit gain.

    Attributes
    ----------
    electrons_per_count
        Photo-electrons that raise the picture by one count.
    read_noise_e
        Standard deviation of a dark pixel, electrons.
    offset_counts
        Level of a dark pixel.
    full_well_e
        Photo-electrons a pixel holds; more are lost.
    """

    electrons_per_count: float = 53.0
    read_noise_e: float = 13.0
    offset_counts: float = 3.0
    full_well_e: float = 13500.0

    def __post_init__(self) -> None:
        if not (self.electrons_per_count > 0.0 and self.full_well_e > 0.0):
            raise ValueError(
                "electrons_per_count and full_well_e must be positive, got "
                f"{self.electrons_per_count} and {self.full_well_e}"
            )
        if not (self.read_noise_e >= 0.0 and self.offset_counts >= 0.0):
            raise ValueError(
                "read_noise_e and offset_counts must not be negative, got "
                f"{self.read_noise_e} and {self.offset_counts}"
            )

    def variance_counts2(self, light_counts: float) -> float:
        r"""Return the variance of a pixel below saturation, counts².

        Notes
        -----
        With n electrons a count and a read noise of r electrons,
        :math:`\sigma^2 = L / n + (r / n)^2 + 1/12`; the last is the rounding to whole counts.
        """
        shot = light_counts / self.electrons_per_count
        return shot + (self.read_noise_e / self.electrons_per_count) ** 2 + 1.0 / 12.0

    def expose(
        self, light_counts: Counts, rng: np.random.Generator, exposure: float = 1.0
    ) -> Picture:
        """Take a picture of the light.

        Parameters
        ----------
        light_counts
            Shape (H, W), light at exposure 1, in counts over the dark level.
        rng
            Draws the noise; nothing else depends on it.
        exposure
            Factor on the exposure time.

        Returns
        -------
        picture
            Shape (H, W), 8 bit.

        Raises
        ------
        ValueError
            If `exposure` is negative or not finite.

        Notes
        -----
        Shot noise is drawn as Gaussian of variance equal to the signal: from 1 count (53
        electrons) upward its difference from Poisson is below the rounding.
        """
        if not 0.0 <= exposure < np.inf:
            raise ValueError(f"exposure must be finite and not negative, got {exposure}")
        light = np.asarray(light_counts * np.float32(exposure))
        light = np.minimum(light, self.full_well_e / self.electrons_per_count, out=light)
        dark_counts2 = (self.read_noise_e / self.electrons_per_count) ** 2
        deviation = cv2.sqrt(light * np.float32(1.0 / self.electrons_per_count) + dark_counts2)
        noise = rng.standard_normal(light.shape, dtype=np.float32)
        noise *= deviation
        light += noise
        light += np.float32(self.offset_counts)
        light = np.maximum(light, 0.0, out=light)
        # Rounds to the nearest count and clips at 255 in one pass.
        return np.asarray(cv2.convertScaleAbs(light), dtype=np.uint8)
