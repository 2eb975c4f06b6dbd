// Include inside a namespace that has lanes.hpp's functions for Lanes.

/// A pixel's channels, grey levels, and the same for several pixels in SIMD lanes.
template <class Lanes>
struct PixelOf {
  Lanes r, g, b;
  Lanes luma() const { return 0.25 * (r + 2 * g + b); }
};

/// Chroma of a pixel with its covariance.
template <class Lanes>
struct ChromaOf {
  Lanes u, v, uu, uv, vv;

  ChromaOf(const ChromaCriterion& criterion, PixelOf<Lanes> pixel) {
    const auto [red, blue] = criterion.gains;
    pixel.r = pixel.r * red;
    pixel.b = pixel.b * blue;
    const Lanes y = pixel.luma();
    u = (pixel.r - pixel.g) / y;
    v = (pixel.b - pixel.g) / y;
    // Derivatives with respect to the camera's R, G and B, times Y.
    const Lanes ur = (1 - u / 4) * red, ug = -1 - u / 2, ub = -u / 4 * blue;
    const Lanes vr = -v / 4 * red, vg = -1 - v / 2, vb = (1 - v / 4) * blue;
    const Lanes scale = criterion.variance / (y * y);
    uu = scale * (ur * ur + ug * ug + ub * ub);
    uv = scale * (ur * vr + ug * vg + ub * vb);
    vv = scale * (vr * vr + vg * vg + vb * vb);
  }

  /// Squared Mahalanobis distance; the covariances of the component and of the chroma add up.
  Lanes distance2(const ChromaCriterion::Component& component) const {
    const Lanes du = u - component.u, dv = v - component.v;
    const Lanes a = component.uu + uu, b = component.uv + uv, c = component.vv + vv;
    return (c * du * du - 2 * b * du * dv + a * dv * dv) / (a * c - b * b);
  }
};

/// Whether distance2() may be within the tolerance: a bound without a division.
template <class Lanes>
inline auto may_fit(const ChromaCriterion& criterion, const ChromaCriterion::Component& component,
                    const PixelOf<Lanes>& pixel) {
  const Lanes r = pixel.r * criterion.gains.red, b = pixel.b * criterion.gains.blue, y = 0.25 * (r + 2 * pixel.g + b);
  const Lanes du = r - pixel.g - component.u * y, dv = b - pixel.g - component.v * y;  // times Y
  return (du * du <= criterion.tolerance2 * (component.uu * y * y + criterion.largest_variance)) &
         (dv * dv <= criterion.tolerance2 * (component.vv * y * y + criterion.largest_variance));
}

/// Replaces clipped channels: the object's brightness is estimated by least squares from the others.
template <class Lanes>
inline PixelOf<Lanes> unclipped(const ChromaCriterion& criterion, const ChromaCriterion::Component& component,
                                const PixelOf<Lanes>& pixel) {
  const Rgb colour{component.colour.r / criterion.gains.red, component.colour.g,
                   component.colour.b / criterion.gains.blue};
  Lanes top = 0, bottom = 0;
  const auto count = [&](Lanes value, double of_unit) {
    top += where(value >= kClipped, 0, value * of_unit);
    bottom += where(value >= kClipped, 0, of_unit * of_unit);
  };
  count(pixel.r, colour.r);
  count(pixel.g, colour.g);
  count(pixel.b, colour.b);
  const Lanes y = where(bottom > 0, top / bottom, 0);
  const auto above = [&](Lanes value, double of_unit) {
    return where(value >= kClipped, greater(value, y * of_unit), value);
  };
  return {above(pixel.r, colour.r), above(pixel.g, colour.g), above(pixel.b, colour.b)};
}

/// ChromaClassifier::contains(), and contains_as_read() if `as_read`.
template <class Lanes>
inline auto contains(const ChromaCriterion& criterion, const PixelOf<Lanes>& pixel, bool as_read = false) {
  using Mask = decltype(pixel.r < pixel.g);
  constexpr double kBrightest = 360;  // see ColourModel: three times as bright as an object of Y = 120
  const Lanes luma = pixel.luma();
  const Mask in_range = (luma >= criterion.min_luma) & (luma <= criterion.max_luma), black = !(luma > 0);
  const Mask r = pixel.r >= kClipped, g = pixel.g >= kClipped, b = pixel.b >= kClipped, clipped = r | g | b;
  const Mask usable = in_range & !black & !(r & g & b);
  Mask found = in_range & black;  // min_luma is 0: black pixels belong, although their chroma is undefined
  for (const ChromaCriterion::Component& component : criterion.object) {
    Mask fits = usable & !found;
    if (!any(fits)) break;
    PixelOf<Lanes> tested = pixel;
    if (!as_read && any(clipped & fits)) {
      const PixelOf<Lanes> brighter = unclipped(criterion, component, pixel);
      tested = {where(clipped, brighter.r, pixel.r), where(clipped, brighter.g, pixel.g),
                where(clipped, brighter.b, pixel.b)};
      fits = fits & !(clipped & (tested.luma() > kBrightest));
    }
    fits = fits & may_fit(criterion, component, tested);
    if (!any(fits)) continue;
    const ChromaOf<Lanes> chroma(criterion, tested);
    const Lanes own = chroma.distance2(component);
    fits = fits & (own <= criterion.tolerance2);
    for (const ChromaCriterion::Component& other : criterion.background) {
      if (!any(fits)) break;
      fits = fits & !(chroma.distance2(other) + other.handicap < own + component.handicap);
    }
    found = found | fits;
  }
  return found;
}
