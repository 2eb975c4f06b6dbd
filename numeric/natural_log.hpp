#pragma once

#include <cmath>
#include <numbers>

namespace multireach {

/// Natural logarithm of a positive, normal number, with a relative or absolute error of 1e-15. Gives the same bits on
/// every machine, unlike the C library's, because it uses only additions, multiplications and divisions: log m =
/// 2 artanh s with s = (m - 1)/(m + 1), by its power series, for m between the square roots of 1/2 and 2.
inline double natural_log(double x) {
  int exponent;
  double m = std::frexp(x, &exponent);  // exact
  if (m < std::numbers::sqrt2 / 2) {
    m *= 2;
    --exponent;
  }
  const double s = (m - 1) / (m + 1), s2 = s * s;
  double series = 0;
  for (int power = 23; power >= 1; power -= 2) series = series * s2 + 1.0 / power;
  return exponent * std::numbers::ln2 + 2 * s * series;
}

}  // namespace multireach
