#include "vision/colour/colour_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "numeric/natural_log.hpp"
#include "numeric/random.hpp"
#include "vision/colour/colour_table.hpp"

namespace multireach::vision {
namespace {

const ColourClass kPinkClass{.references = {{220, 40, 110}, {60, 90, 200}}, .tolerance = 0.4};

Rgb random_pixel(const CounterRandom& random, uint64_t k) {
  const auto value = [&](uint64_t channel) { return static_cast<double>(random.bits(3 * k + channel) % 256); };
  return {value(0), value(1), value(2)};
}

TEST(NaturalLog, IsThatOfTheLibrary) {
  const CounterRandom random(2);
  std::cout << "seed 2\n";
  for (uint64_t k = 0; k < 20000; ++k) {
    const double x = std::ldexp(random.uniform(2 * k, 1, 2), static_cast<int>(random.bits(2 * k + 1) % 200) - 100);
    ASSERT_NEAR(natural_log(x), std::log(x), 1e-15 * std::max(1.0, std::abs(std::log(x)))) << x;
  }
  EXPECT_EQ(natural_log(1), 0);
}

TEST(ColourModel, OfAClassHasItsMembers) {
  // Without noise and clipping, membership must follow the definition of ColourClass.
  ColourModel model = model_of(kPinkClass);
  model.noise_grey_levels = 0;
  const CounterRandom random(4);
  std::cout << "seed 4\n";
  int members = 0;
  for (uint64_t k = 0; k < 200000; ++k) {
    const Rgb pixel = random_pixel(random, k);
    const double luma = (pixel.r + 2 * pixel.g + pixel.b) / 4;
    if (std::max({pixel.r, pixel.g, pixel.b}) >= kClipped || luma == 0) continue;
    bool expected = false;
    for (const Rgb& reference : kPinkClass.references) {
      const double y = (reference.r + 2 * reference.g + reference.b) / 4;
      const double du = (pixel.r - pixel.g) / luma - (reference.r - reference.g) / y;
      const double dv = (pixel.b - pixel.g) / luma - (reference.b - reference.g) / y;
      expected |= std::hypot(du, dv) < kPinkClass.tolerance;
    }
    expected &= luma >= kPinkClass.min_luma && luma <= kPinkClass.max_luma;
    ASSERT_EQ(is_member(model, {}, pixel), expected) << pixel.r << " " << pixel.g << " " << pixel.b;
    members += expected ? 1 : 0;
  }
  EXPECT_GT(members, 1000);
}

TEST(ColourModel, ChromaAndColourAreInverse) {
  const Rgb colour = colour_of(chroma_of({30, 80, 170}));
  EXPECT_NEAR(luma_of(colour), 1, 1e-15);
  EXPECT_NEAR(colour.r, 30.0 / 90, 1e-15);
  EXPECT_NEAR(colour.g, 80.0 / 90, 1e-15);
  EXPECT_NEAR(colour.b, 170.0 / 90, 1e-15);
}

TEST(ColourModel, NearWhitePixelsBelongToNoColour) {
  for (const Rgb& reference : {Rgb{200, 40, 40}, Rgb{40, 40, 200}, Rgb{220, 40, 110}, Rgb{40, 150, 160}}) {
    ColourModel model = model_of({.references = {reference}});
    for (const Rgb& white : {Rgb{255, 246, 246}, Rgb{246, 246, 255}, Rgb{246, 255, 246}, Rgb{255, 240, 255},
                             Rgb{255, 255, 235}, Rgb{240, 255, 255}, Rgb{255, 225, 225}}) {
      EXPECT_FALSE(is_member(model, {}, white))
          << reference.r << " " << reference.g << " " << reference.b << ": " << white.r << " " << white.g;
    }
  }
}

TEST(ColourModel, ClippedChannelsCountAsWhatTheyMayHaveBeen) {
  const ColourModel model = model_of({.references = {{220, 40, 110}}, .tolerance = 0.4});
  EXPECT_TRUE(is_member(model, {}, {255, 80, 220})) << "twice as bright";
  EXPECT_TRUE(is_member(model, {}, {255, 120, 255})) << "three times";
  EXPECT_FALSE(is_member(model, {}, {240, 80, 220})) << "not clipped: it is what it is";
  EXPECT_FALSE(is_member(model, {}, {255, 230, 240})) << "a highlight with a tint";
  EXPECT_FALSE(is_member(model, {}, {255, 255, 110})) << "yellow";
  EXPECT_FALSE(is_member(model, {}, {250, 250, 250})) << "says nothing";
}

TEST(ColourModel, DarkPixelsAreLessSureOfTheirChroma) {
  ColourModel model = model_of({.references = {{220, 40, 110}}, .tolerance = 0.3});
  model.min_luma = 10;
  const auto off = [](double y) {  // a chroma outside the tolerance
    const Rgb colour = colour_of({1.7561 - 0.36, 0.6829});
    return Rgb{y * colour.r, y * colour.g, y * colour.b};
  };
  EXPECT_FALSE(is_member(model, {}, off(120)));
  EXPECT_TRUE(is_member(model, {}, off(15)));
  EXPECT_FALSE(is_member(model, {}, off(9))) << "too dark for anything";
  EXPECT_FALSE(is_member(model, {}, {12, 12, 12})) << "grey";
}

TEST(ColourModel, ALikelierBackgroundTakesPixelsAway) {
  ColourModel model = model_of({.references = {{220, 40, 110}}, .tolerance = 0.8});
  const Rgb between{200, 60, 90};
  ASSERT_TRUE(is_member(model, {}, between));
  model.background.push_back({chroma_of({190, 70, 80}), 0.01 * Eigen::Matrix2d::Identity(), 1});
  EXPECT_FALSE(is_member(model, {}, between));
  EXPECT_TRUE(is_member(model, {}, {220, 40, 110}));
  model.background[0].weight = 1e-6;
  EXPECT_TRUE(is_member(model, {}, between)) << "a background that hardly exists";
}

TEST(ColourModel, AShiftIsAGainOfTheCamera) {
  const ColourModel model = model_of({.references = {{220, 40, 110}}, .tolerance = 0.3});
  const WhiteBalanceGains shift{.red = 1.6, .blue = 0.7};
  const CounterRandom random(8);
  std::cout << "seed 8\n";
  ColourModel noiseless = model;
  noiseless.noise_grey_levels = noiseless.min_luma = 0;
  for (uint64_t k = 0; k < 50000; ++k) {
    const Rgb pixel = random_pixel(random, k), as_before{1.6 * pixel.r, pixel.g, 0.7 * pixel.b};
    if (std::max({as_before.r, pixel.r, pixel.g, pixel.b}) >= kClipped || pixel.g == 0) continue;
    ASSERT_EQ(is_member(noiseless, shift, pixel), is_member(noiseless, {}, as_before));
  }
}

TEST(ColourModel, RefusesWhatMakesNoSense) {
  EXPECT_THROW(model_of({}), std::invalid_argument);
  EXPECT_THROW(model_of({.references = {{0, 0, 0}}}), std::invalid_argument);
  EXPECT_THROW(model_of({.references = {{220, 40, 110}}, .tolerance = 0}), std::invalid_argument);
  const ColourModel good = model_of(kPinkClass);
  EXPECT_NO_THROW(check(good));
  const auto refused = [&](const auto& spoil) {
    ColourModel model = good;
    spoil(model);
    EXPECT_THROW(check(model), std::invalid_argument);
    EXPECT_THROW(ColourTable{model}, std::invalid_argument);
  };
  refused([](ColourModel& model) { model.object.clear(); });
  refused([](ColourModel& model) { model.object[0].covariance.setZero(); });
  refused([](ColourModel& model) { model.object[0].covariance << 1, 2, 2, 1; });
  refused([](ColourModel& model) { model.object[0].mean.x() = std::nan(""); });
  refused([](ColourModel& model) { model.object[0].weight = 0; });
  refused([](ColourModel& model) { model.tolerance = -1; });
  refused([](ColourModel& model) { model.max_luma = model.min_luma; });
  refused([](ColourModel& model) { model.noise_grey_levels = std::nan(""); });
}

TEST(ColourTable, IsTheModelUpToItsCells) {
  const ColourModel model = model_of(kPinkClass);
  const WhiteBalanceGains shift{.red = 1.2, .blue = 0.9};
  const ColourTable members(model, shift);
  const CounterRandom random(6);
  std::cout << "seed 6\n";
  // Table and model may differ only near the boundary of the class: if so, the model's answer changes at a corner of a
  // cube of one table cell around the pixel.
  const auto at_the_border = [&](const Rgb& pixel, bool member) {
    for (int corner = 0; corner < 8; ++corner) {
      const auto beside = [&](double value, int bit) {
        return value + (corner >> bit & 1 ? 1 : -1) * (1 + std::sqrt(value) / 2);
      };
      const Rgb other{beside(pixel.r, 0), beside(pixel.g, 1), beside(pixel.b, 2)};
      if (is_member(model, shift, other) != member) return true;
    }
    return false;
  };
  int different = 0, either = 0;
  for (uint64_t k = 0; k < 200000; ++k) {
    const Rgb pixel = random_pixel(random, k);
    const bool in_table =
        members.contains(static_cast<uint8_t>(pixel.b), static_cast<uint8_t>(pixel.g), static_cast<uint8_t>(pixel.r));
    const bool in_model = is_member(model, shift, pixel);
    either += in_table || in_model ? 1 : 0;
    if (in_table == in_model) continue;
    ++different;
    EXPECT_TRUE(at_the_border(pixel, in_model)) << pixel.r << " " << pixel.g << " " << pixel.b;
  }
  EXPECT_GT(either, 5000);
  EXPECT_LT(different, 0.15 * either) << "measured: 0.13, of the pixels of two small classes";
  EXPECT_FALSE(ColourTable().contains(110, 40, 220)) << "nothing is a member of no model";
}

}  // namespace
}  // namespace multireach::vision
