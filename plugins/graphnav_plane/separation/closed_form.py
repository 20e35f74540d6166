"""FastICA of two mixtures with the cubic nonlinearity, in closed form.

With that nonlinearity FastICA seeks directions in which the whitened samples' kurtosis is extreme [Hyvärinen, Oja: A
fast fixed-point algorithm for independent component analysis, 1997]. For two whitened rows (a, b) the kurtosis
along (cos t, sin t) needs only their five fourth moments, m_jk = E[a^j b^k]::

    kurt(t) = m40 c^4 + 4 m31 c^3 s + 6 m22 c^2 s^2 + 4 m13 c s^3 + m04 s^4 - 3

and it is extreme where x = tan t solves

    m31 + (3 m22 - m40) x + 3 (m13 - m31) x^2 + (m04 - 3 m22) x^3 - m13 x^4 = 0

or t is a right angle. Which of these FastICA finds depends on its start. This takes the highest: the component of the
obstacles is zero over most of the picture, so its kurtosis is high, while that of a planar flow, which is spread
evenly, is low. (With large obstacles the most extreme of either sign is that of the planar flow.) Only if the kurtosis
is negative for all angles it takes the lowest. The second component is uncorrelated with the first, as in deflation.
"""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Doubles


def rotation(samples: Doubles) -> Doubles:
    """Return the rotation (2, 2) whose rows take whitened samples (2, n) to the components, in the order found."""
    a, b = samples
    aa, ab, bb = a * a, a * b, b * b
    m40, m31, m22, m13, m04 = (float(x @ y) / a.size for x, y in ((aa, aa), (aa, ab), (aa, bb), (ab, bb), (bb, bb)))
    x = np.roots([-m13, m04 - 3 * m22, 3 * (m13 - m31), 3 * m22 - m40, m31])
    t = np.append(np.arctan(x.real), np.pi / 2)
    c, s = np.cos(t), np.sin(t)
    kurtosis = m40 * c**4 + 4 * m31 * c**3 * s + 6 * m22 * c**2 * s**2 + 4 * m13 * c * s**3 + m04 * s**4 - 3
    best = np.argmax(kurtosis) if kurtosis.max() > 0 else np.argmin(kurtosis)
    return np.array([[c[best], s[best]], [-s[best], c[best]]])
