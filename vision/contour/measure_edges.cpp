#include "vision/contour/measure_edges.hpp"

#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/contour/measure_edges.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "numeric/wide_lanes-inl.hpp"
#include "vision/contour/edge_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach::vision {
namespace HWY_NAMESPACE {

constexpr double kMinContrast = 12;  // grey levels
// Error of the colours of both sides in any direction, apart from the noise, grey levels. Without it, noise-free images
// would not use the rim's brightness at all, which is most of the contrast in front of a dark background.
constexpr double kColourError = 1.5;

/// The object's share of a pixel as a function of the edge position. The edge is averaged over two boxes: the pixel's
/// width, and a box for the edge's slant and the blur.
class Coverage {
 public:
  explicit Coverage(Lanes spread_px) {
    constexpr double kSharpest = 0.05;  // px
    const Lanes spread = greater(spread_px, kSharpest);
    height_ = 1.0 / greater(1.0, spread);
    flat_ = 0.5 * absolute(1.0 - spread);
    ramp_ = lesser(1.0, spread);
  }
  /// The object's share for an edge `d` px outwards of the pixel's centre.
  Lanes share(Lanes d) const { return 0.5 + with_sign_of(half_share(absolute(d)), d); }
  /// Derivative of share().
  Lanes slope(Lanes d) const {
    const Lanes beyond = absolute(d) - flat_;
    return where(beyond <= 0.0, height_, where(beyond < ramp_, height_ * (1.0 - beyond / ramp_), 0.0));
  }

 private:
  Lanes half_share(Lanes d) const {
    const Lanes rest = greater(0.0, 1.0 - (d - flat_) / ramp_);
    return where(d <= flat_, height_ * d, height_ * (flat_ + 0.5 * ramp_ * (1.0 - rest * rest)));
  }
  Lanes height_, flat_, ramp_;  // trapezoid: its height, half its flat top and the width of each ramp
};

/// The object's share of each pixel in a window, and the derivative of the edge position with respect to each share.
struct Window {
  static constexpr int kMost = 2 * EdgeModel::kWidestHalf + 1;
  int half;
  std::array<Lanes, kMost> share, influence;

  /// Edge position from the sum of the shares; needs no blur model.
  Lanes by_area() {
    Lanes covered = 0.0;
    for (int i = 0; i <= 2 * half; ++i) {
      covered += share[i];
      influence[i] = 1.0;
    }
    return covered - (half + 0.5);
  }

  /// Edge position by least squares from the start `position`, for a known blur: the noise of pixels that the edge does
  /// not touch has no effect. `position` where the fit fails.
  Lanes by_shape(Lanes position, Lanes spread_px) {
    const Coverage coverage(spread_px);
    constexpr int kSteps = 3;
    constexpr double kLeast = 0.1;
    Lanes at = position;
    LanesMask fits = !no_lane();
    std::array<Lanes, kMost> slopes;
    for (int step = 0; step < kSteps; ++step) {
      Lanes squares = 0.0, sum = 0.0;
      for (int i = 0; i <= 2 * half; ++i) {
        const Lanes away = at - static_cast<double>(i - half);
        slopes[i] = coverage.slope(away);
        squares += slopes[i] * slopes[i];
        sum += slopes[i] * (share[i] - coverage.share(away));
      }
      fits = fits & !(squares < kLeast);
      for (int i = 0; i <= 2 * half; ++i) slopes[i] = slopes[i] / squares;
      at += clamped(sum / squares, -0.5, 0.5);
    }
    fits = fits & (absolute(at - position) < 1.0);
    for (int i = 0; i <= 2 * half; ++i) influence[i] = where(fits, slopes[i], influence[i]);
    return where(fits, at, position);
  }
};

/// Mean colour of the pixels next to the window, inside (-1) or outside (1) of the edge.
HWY_INLINE Colour mean_beside(const EdgeBlock& block, int outwards, int first) {
  Colour sum = pixel_of(block, outwards * (block.half + 1), first);
  for (int k = 2; k <= kSide; ++k) sum = sum + pixel_of(block, outwards * (block.half + k), first);
  return {sum.b / double{kSide}, sum.g / double{kSide}, sum.r / double{kSide}};
}

/// The colours of both sides of an edge, taken next to its window.
struct Sides {
  Colour inside, outside;
  Colour slope;           // of the background's colour, per pixel
  double belief;          // in the measured slope
  double slope_noise2;    // its variance
  double outside_middle;  // where `outside` holds, pixels outwards of the window's middle

  Sides(const EdgeBlock& block, const EdgeModel& model, int first)
      : slope_noise2(model.noise * model.noise / 2), outside_middle(block.half + 0.5 * (kSide + 1)) {
    // A slope over three pixels has the noise variance noise^2 / 2: shrink it by the usual variance of slopes (Wiener).
    belief = model.outside_slope2 / (model.outside_slope2 + slope_noise2);
    const int half = block.half;
    slope = Lanes(belief) *
            (Lanes(1.0 / (kSide - 1)) * (pixel_of(block, half + kSide, first) - pixel_of(block, half + 1, first)));
    inside = mean_beside(block, -1, first);
    outside = mean_beside(block, 1, first);
  }
  Colour background(int k) const { return outside + Lanes(k - outside_middle) * slope; }
};

/// Fisher's discriminant between the rim's colour and the background's. The noise is equal in all channels, plus
/// shading error along the object's own colour, plus, where the chroma is unreliable, chroma error perpendicular to the
/// brightness direction.
HWY_INLINE Colour discriminant(const Colour& rim, const Colour& difference, const EdgeModel& model) {
  const Lanes brightness2 = greater(1.0, dot(rim, rim));
  const Lanes shading2 = model.shading_error * model.shading_error * brightness2;
  const Lanes chroma2 = model.chroma_error * model.chroma_error * dot(difference, difference);
  const Lanes equal2 = model.noise * model.noise + kColourError * kColourError + chroma2;
  const Eigen::Vector3d luma = luma_direction();
  const std::array<Lanes, 3> own = {rim.b, rim.g, rim.r};
  std::array<std::array<Lanes, 3>, 3> m;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      m[i][j] = (i == j ? equal2 : Lanes(0.0)) +
                (shading2 / brightness2 * own[i] * own[j] - chroma2 * luma[i] * Lanes(luma[j]));
  }
  const auto cofactor = [&](int i, int j) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    return m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
  };
  const Lanes determinant = cofactor(0, 0) * m[0][0] + cofactor(1, 0) * m[1][0] + cofactor(2, 0) * m[2][0];
  const Lanes inverse = 1.0 / determinant;
  const auto row = [&](int i) {
    return Colour{cofactor(0, i) * inverse, cofactor(1, i) * inverse, cofactor(2, i) * inverse};
  };
  const Colour last = row(2);
  return {dot(row(0), difference), dot(row(1), difference),
          last.b * difference.b + (last.g * difference.g + last.r * difference.r)};
}

/// Shading of the object across an edge, relative to the pixels next to the window, represented by the middle one of
/// them; at the rim and beyond, that of the rim.
class RimShading {
 public:
  RimShading(const EdgeLanes& edge, const Shading& shading, double radius_px, int half)
      : edge_(edge), known_(shading.known()), radius_px_(radius_px), last_inside_(rounded_down(edge.expected() + 0.5)) {
    rim_.fill(0.0);
    if (!known_) return;
    beside_ = terms_at(Lanes(-half - (kSide + 1) / 2));
    rim_ = difference(terms_at(last_inside_));
  }
  const Terms& at_rim() const { return rim_; }
  Terms at(int k) const {
    if (!known_) return rim_;
    const LanesMask inside = Lanes(k) < last_inside_;
    if (!any(inside)) return rim_;
    Terms terms = difference(terms_at(Lanes(k)));
    for (size_t i = 0; i < terms.size(); ++i) terms[i] = where(inside, terms[i], rim_[i]);
    return terms;
  }

 private:
  Terms terms_at(Lanes outwards) const { return terms_of(edge_.surface_normal(radius_px_, outwards)); }
  Terms difference(Terms terms) const {
    for (size_t i = 0; i < terms.size(); ++i) terms[i] -= beside_[i];
    return terms;
  }

  const EdgeLanes& edge_;
  bool known_;
  double radius_px_;
  Lanes last_inside_;  // pixel that contains the edge
  Terms beside_, rim_;
};

/// Sets the errors of the edges from the shares of the windows' pixels and their influence. `w` is the discriminant,
/// `span` its value for the difference of both sides.
HWY_INLINE void propagate_errors(const EdgeModel& model, const Window& window, const Sides& sides,
                                 const std::array<Terms, Window::kMost>& shaded, const Colour& rim, const Colour& w,
                                 Lanes span, Lanes outward, int first, EdgeBlock& block) {
  const int half = window.half;
  const double noise2 = model.noise * model.noise;
  const Lanes length = square_root(dot(w, w));
  // d at / d inside = -covered, d at / d outside = -uncovered, each the mean of kSide pixels; d at / d slope = -lever.
  Lanes covered = 0.0, uncovered = 0.0, lever = 0.0, pixels = 0.0;
  Terms sum;
  sum.fill(0.0);
  for (int i = 0; i <= 2 * half; ++i) {
    const Lanes share = window.share[i], influence = window.influence[i];
    covered += influence * share;
    uncovered += influence * (1.0 - share);
    lever += influence * (1.0 - share) * (i - half - sides.outside_middle);
    pixels += influence * influence;
    const Lanes of_object = influence * clamped(share, 0.0, 1.0);
    for (size_t k = 0; k < sum.size(); ++k) sum[k] += of_object * shaded[i][k];
  }
  const Lanes gain2 = length * length / (span * span), belief = sides.belief;
  const Lanes random =
      noise2 * (pixels + (covered * covered + uncovered * uncovered) / double{kSide}) +
      lever * lever * (belief * belief * sides.slope_noise2 + (1.0 - belief) * (1.0 - belief) * model.outside_slope2);
  // Background texture: curvature of the background beyond what the noise explains.
  const Lanes second = dot(w, pixel_of(block, half + 1, first) - Lanes(2.0) * pixel_of(block, half + 2, first) +
                                  pixel_of(block, half + 3, first)) /
                       span;
  const Lanes texture = uncovered * uncovered * greater(0.0, second * second / 6.0 - gain2 * noise2);
  store(square_root(gain2 * random + texture), block.sigma_px, first);
  // The shading model's error acts on about one pixel at most; the error of its fit acts on all covered pixels.
  store(model.shading_error * dot(w, rim) / span * clamped(covered, 0.0, 1.0), block.shading_px, first);
  for (size_t k = 0; k < sum.size(); ++k) store(sum[k], block.shading_terms[k], first);
  const Lanes gain = -outward / span;
  store(gain * w.b, block.shading_gain[0], first);
  store(gain * w.g, block.shading_gain[1], first);
  store(gain * w.r, block.shading_gain[2], first);
}

/// Measures the edges `first` to first + kWidth - 1 of a block; one bit for each that is an edge.
HWY_INLINE uint32_t measure_lanes(const EdgeModel& model, const Shading& shading, int first, EdgeBlock& block) {
  const int half = block.half;
  const EdgeLanes edge(block, first);
  const Sides sides(block, model, first);
  const RimShading rim_shading(edge, shading, model.radius_px, half);
  const Colour rim = sides.inside + colour_of(shading, rim_shading.at_rim());
  const Colour difference = rim - (sides.outside - Lanes(sides.outside_middle) * sides.slope);
  const Colour w = discriminant(rim, difference, model);
  const Lanes span = dot(w, difference);
  LanesMask is_edge = span > kMinContrast * square_root(dot(w, w));

  Window window{.half = half, .share = {}, .influence = {}};
  std::array<Terms, Window::kMost> shaded;
  for (int k = -half; k <= half; ++k) {
    Terms& here = shaded[half + k];
    here = rim_shading.at(k);
    const Colour of_object = sides.inside + colour_of(shading, here), of_background = sides.background(k);
    const Lanes whole = dot(w, of_object - of_background);
    is_edge = is_edge & (whole > 0.2 * span);
    window.share[half + k] = dot(w, pixel_of(block, k, first) - of_background) / whole;
  }
  if (!any(is_edge)) return 0;
  Lanes from_middle = window.by_area();  // outwards
  if (model.blur2 >= 0) {
    const Lanes tilt2 = 1.0 / (edge.cosine * edge.cosine) - 1.0;
    from_middle = window.by_shape(from_middle, square_root(tilt2 + 12 * model.blur2));
  }
  is_edge = is_edge & (absolute(from_middle - edge.expected()) < double(half));
  store(edge.middle + edge.outward * from_middle, block.found_at, first);
  propagate_errors(model, window, sides, shaded, rim, w, span, edge.outward, first, block);
  const Colour background = rim - difference;
  store(rim.b, block.rim[0], first);
  store(rim.g, block.rim[1], first);
  store(rim.r, block.rim[2], first);
  store(background.b, block.background[0], first);
  store(background.g, block.background[1], first);
  store(background.r, block.background[2], first);
  return bits_of(is_edge);
}

void measure_block(const EdgeModel& model, const Shading& shading, EdgeBlock& block) {
  for (int first = 0; first < block.count; first += kWidth)
    block.marked |= measure_lanes(model, shading, first, block) << first;
}

void measure_blur_block(EdgeBlock& block) {
  const Eigen::Vector3d luma = luma_direction();
  for (int first = 0; first < block.count; first += kWidth) {
    const EdgeLanes edge(block, first);
    const Colour outside = mean_beside(block, 1, first), difference = mean_beside(block, -1, first) - outside;
    const Lanes tilt2 = 1.0 / (edge.cosine * edge.cosine) - 1.0;
    const auto along = [&](const Colour& w) -> Lanes {
      const Lanes span = dot(w, difference);
      Lanes moment = 0.0, moment2 = 0.0, previous = 1.0;
      for (int k = -block.half; k <= block.half + 1; ++k) {
        const Lanes share = k <= block.half ? dot(w, pixel_of(block, k, first) - outside) / span : Lanes(0.0);
        const double position = k - 0.5;
        moment += (previous - share) * position;
        moment2 += (previous - share) * position * position;
        previous = share;
      }
      // Subtract the variance of the pixel's width (1/12) twice: once for each pixel's average, once for the
      // difference.
      return moment2 - moment * moment - 1.0 / 6 - tilt2 / 12.0;
    };
    const Colour brightness = {luma[0], luma[1], luma[2]};
    const Lanes of_luma = dot(brightness, difference);
    store(of_luma * of_luma / greater(1.0, dot(difference, difference)), block.luma_share, first);
    store(along(difference), block.colour_blur2, first);
    store(where(of_luma == 0.0, 0.0, along(brightness)), block.luma_blur2, first);
  }
}

void find_surface_block(double radius_px, EdgeBlock& block) {
  for (int first = 0; first < block.count; first += kWidth) {
    const EdgeLanes edge(block, first);
    for (size_t i = 0; i < block.surface_terms.size(); ++i) {
      const Terms terms = terms_of(edge.surface_normal(radius_px, Lanes(-EdgeBlock::pixels_inside(i))));
      for (size_t k = 0; k < terms.size(); ++k) store(terms[k], block.surface_terms[i][k], first);
    }
  }
}

void mark_painted_block(const Shading& shading, double radius_px, double most, EdgeBlock& block) {
  for (int first = 0; first < block.count; first += kWidth) {
    const EdgeLanes edge(block, first);
    LanesMask painted = no_lane();
    for (int k = block.half + 1; k <= block.half + kSide; ++k) {
      const Colour apart =
          pixel_of(block, -k, first) - colour_of(shading, terms_of(edge.surface_normal(radius_px, Lanes(-k))));
      painted = painted | (square_root(dot(apart, apart)) > most);
    }
    block.marked |= bits_of(painted) << first;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace multireach::vision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace multireach::vision {

HWY_EXPORT(measure_block);
HWY_EXPORT(measure_blur_block);
HWY_EXPORT(find_surface_block);
HWY_EXPORT(mark_painted_block);

namespace {

/// The width of the windows, and the pixels that are used.
struct BlockPixels {
  int half, begin, end;
};

/// Calls `compute` with blocks of those edgels that are `chosen`, then `take` for each edgel.
template <class Chosen, class Compute, class Take>
void for_blocks(const BlockPixels& pixels, std::span<const int> which, std::span<const EdgeProfile> profiles,
                std::span<ContourEdgel> edgels, const Chosen& chosen, const Compute& compute, const Take& take) {
  EdgeBlock block;
  block.half = pixels.half;
  block.begin = pixels.begin;
  block.end = pixels.end;
  std::array<int, kRowLanes> members;
  const auto finish = [&] {
    if (block.count == 0) return;
    block.fill_up();
    block.marked = 0;
    compute(block);
    for (int lane = 0; lane < block.count; ++lane) take(block, lane, edgels[members[lane]]);
    block.count = 0;
  };
  for (const int k : which) {
    if (!chosen(edgels[k])) continue;
    members[block.count] = k;
    block.set(block.count++, edgels[k].edge, profiles[edgels[k].profile]);
    if (block.count == kRowLanes) finish();
  }
  finish();
}

/// The same for all edgels, each with its own window. With `inside`, only the pixels inside of it are used.
template <class Compute, class Take>
void for_blocks(bool inside, std::span<const int> which, std::span<const EdgeProfile> profiles,
                std::span<ContourEdgel> edgels, const Compute& compute, const Take& take) {
  constexpr int kSide = EdgeModel::kSide;
  for (int half = 1; half <= EdgeModel::kWidestHalf; ++half) {
    const auto chosen = [half](const ContourEdgel& edgel) { return edgel.half == half; };
    const BlockPixels pixels = {half, -half - kSide, inside ? -half : half + kSide + 1};
    for_blocks(pixels, which, profiles, edgels, chosen, compute, take);
  }
}

}  // namespace

void measure_edges(std::span<const int> which, std::span<const EdgeProfile> profiles, const EdgeModel& model,
                   const Shading& shading, std::span<ContourEdgel> edgels) {
  for_blocks(
      false, which, profiles, edgels,
      [&](EdgeBlock& block) {
        HWY_DYNAMIC_DISPATCH(measure_block)
        (model, shading, block);
      },
      [](const EdgeBlock& block, int lane, ContourEdgel& edgel) {
        edgel.is_edge = block.marked >> lane & 1;
        if (edgel.is_edge) edgel.found = block.edge(lane);
      });
}

void measure_blur(std::span<const int> which, std::span<const EdgeProfile> profiles, std::span<ContourEdgel> edgels) {
  constexpr int kHalf = 2, kSide = EdgeModel::kSide;
  for_blocks(
      {kHalf, -kHalf - kSide, kHalf + kSide + 1}, which, profiles, edgels, [](const ContourEdgel&) { return true; },
      [](EdgeBlock& block) {
        HWY_DYNAMIC_DISPATCH(measure_blur_block)
        (block);
      },
      [](const EdgeBlock& block, int lane, ContourEdgel& edgel) { edgel.blur = block.blur(lane); });
}

void read_surface(std::span<const int> which, std::span<const EdgeProfile> profiles, double radius_px,
                  std::span<ContourEdgel> edgels, std::vector<SurfaceColour>& surface) {
  surface.clear();
  for_blocks(
      {0, -EdgeProfile::kReach, 0}, which, profiles, edgels, [](const ContourEdgel&) { return true; },
      [&](EdgeBlock& block) {
        HWY_DYNAMIC_DISPATCH(find_surface_block)
        (radius_px, block);
      },
      [&](const EdgeBlock& block, int lane, const ContourEdgel& edgel) {
        for (size_t i = 0; i < block.surface_terms.size(); ++i) {
          if (EdgeBlock::pixels_inside(i) > edgel.half) surface.push_back(block.surface_colour(i, lane));
        }
      });
}

void mark_painted(std::span<const int> which, std::span<const EdgeProfile> profiles, const Shading& shading,
                  double radius_px, double most, std::span<ContourEdgel> edgels) {
  for_blocks(
      true, which, profiles, edgels,
      [&](EdgeBlock& block) {
        HWY_DYNAMIC_DISPATCH(mark_painted_block)
        (shading, radius_px, most, block);
      },
      [](const EdgeBlock& block, int lane, ContourEdgel& edgel) { edgel.painted = block.marked >> lane & 1; });
}

}  // namespace multireach::vision
#endif
