// Include inside a namespace that has `sine_and_cosine` for Lanes; see sine_cosine.inl.hpp.

/// atan2(y, x), from -pi to pi, with error at most 1e-15; 0 for the origin. Both must be finite.
template <class Lanes>
inline Lanes finite_arc_tangent(Lanes y, Lanes x) {
  const Lanes ax = absolute(x), ay = absolute(y);
  const auto steep = ay > ax;
  const Lanes longer = where(steep, ay, ax);
  const Lanes t = where(steep, ax, ay) / where(longer == 0, 1, longer);  // tangent of an angle of at most pi/4
  // The guess is at most 0.004 off; the remaining angle has the tangent d.
  const Lanes guess = t * (std::numbers::pi / 4 + 0.273 * (1 - t));
  Lanes s, c;
  sine_and_cosine(guess, s, c);
  const Lanes d = (t * c - s) / (c + t * s), d2 = d * d;
  Lanes angle = guess + d * (1 - d2 * (1.0 / 3 - d2 * (1.0 / 5)));
  angle = where(steep, std::numbers::pi / 2 - angle, angle);
  angle = where(x < 0, std::numbers::pi - angle, angle);
  return where(y < 0, -angle, angle);
}
