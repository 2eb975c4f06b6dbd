#include "vision/colour/learn_colour.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "numeric/random.hpp"
#include "vision/colour/find.hpp"

namespace multireach::vision {
namespace {

constexpr int kWidth = 320, kHeight = 240, kRadius = 30;
const cv::Point kCentre(150, 110);
const cv::Rect kAround(115, 75, 70, 70);  // slightly larger than the object: the corners show the wall

/// A picture of a shaded disc of one colour, crossed by a skin-coloured stripe, before a wall of grey texture and a
/// skin-coloured arm. Scaled by `exposure`, with noise of two grey levels.
cv::Mat scene(const Rgb& object, double wall, double exposure, uint64_t seed) {
  const CounterRandom random(seed);
  cv::Mat image(kHeight, kWidth, CV_8UC3);
  uint64_t counter = 0;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const double texture = wall * (0.75 + 0.25 * std::sin(0.15 * column) * std::sin(0.23 * row));
      Rgb colour{1.01 * texture, texture, 0.97 * texture};
      const double from = std::hypot(column - kCentre.x, row - kCentre.y), shade = 1 - 0.4 * (row - 80) / 60;
      if (from < kRadius) colour = {object.r * shade, object.g * shade, object.b * shade};
      if (std::abs(row - 120) < 5 && column > 140) colour = {190, 140, 110};
      if (std::abs(row - 120) < 20 && column > 200) colour = {190, 140, 110};
      for (const auto& [channel, value] : {std::pair(0, colour.b), std::pair(1, colour.g), std::pair(2, colour.r)}) {
        const double noise = 2 * std::sqrt(12.0) * (random.uniform(counter++) - 0.5);
        image.at<cv::Vec3b>(row, column)[channel] =
            static_cast<uint8_t>(std::clamp(exposure * value + noise + 0.5, 0.0, 255.0));
      }
    }
  }
  return image;
}

/// The largest blob that a learned model finds in an image.
Blob largest(const LearnedColour& learned, const cv::Mat& image) {
  BlobFinder finder;
  const FoundBlobs found = finder.find(image, {0, 0, image.cols, image.rows}, ColourTable(learned.model));
  return found.blobs.empty() ? Blob() : found.blobs[0];
}

/// Distance of the centroid in pixels plus 20 times the relative error of the area, from the disc without its stripe.
double distance_from_disc(const Blob& blob) {
  const double area = 3.14159 * kRadius * kRadius - 9 * 39;
  return (blob.centroid - Eigen::Vector2d(kCentre.x, kCentre.y)).norm() + 20 * std::abs(blob.area / area - 1);
}

TEST(LearnColour, FindsTheObjectInThePictureAndInOtherLight) {
  std::cout << "seeds 1 to 12\n";
  uint64_t seed = 1;
  for (const Rgb& object : {Rgb{220, 40, 110}, Rgb{40, 150, 60}, Rgb{50, 90, 200}, Rgb{210, 200, 40}}) {
    const LearnedColour learned = learn_colour(scene(object, 150, 1, seed), kAround);
    ASSERT_EQ(learned.status, LearnedColour::Status::kLearned) << description(learned.status);
    EXPECT_FALSE(learned.by_brightness);
    EXPECT_GT(learned.kept, 0.85);
    EXPECT_LT(learned.background, 0.002);
    for (const double exposure : {1.0, 0.4, 1.5}) {
      EXPECT_LT(distance_from_disc(largest(learned, scene(object, 150, exposure, ++seed))), 5)
          << object.r << " " << object.g << " " << object.b << ", exposure " << exposure;
    }
    EXPECT_LT((learned.model.object[0].mean - chroma_of(object)).norm(), 0.1);
  }
}

TEST(LearnColour, TellsBlackAndWhiteByBrightness) {
  std::cout << "seed 3\n";
  for (const auto& [object, wall] :
       {std::pair(Rgb{22, 21, 23}, 190.0), std::pair(Rgb{0, 0, 0}, 190.0), std::pair(Rgb{215, 220, 225}, 60.0)}) {
    const cv::Mat image = scene(object, wall, 1, 3);
    const LearnedColour learned = learn_colour(image, kAround);
    ASSERT_EQ(learned.status, LearnedColour::Status::kLearned) << description(learned.status);
    EXPECT_TRUE(learned.by_brightness);
    EXPECT_GT(learned.kept, 0.85);
    EXPECT_LT(learned.background, 0.01);
    EXPECT_LT(distance_from_disc(largest(learned, image)), 5) << object.g;
  }
}

TEST(LearnColour, SaysWhatItCannotLearn) {
  using Status = LearnedColour::Status;
  const cv::Mat image = scene({220, 40, 110}, 150, 1, 4);
  EXPECT_EQ(learn_colour(cv::Mat(), kAround).status, Status::kBadImage);
  EXPECT_EQ(learn_colour(cv::Mat(50, 50, CV_8UC1), kAround).status, Status::kBadImage);
  EXPECT_EQ(learn_colour(image, {400, 10, 50, 50}).status, Status::kTooSmall);
  EXPECT_EQ(learn_colour(image, {10, 10, 6, 6}).status, Status::kTooSmall);
  EXPECT_EQ(learn_colour(image, {10, 10, -60, 60}).status, Status::kTooSmall);
  EXPECT_EQ(learn_colour(image, {20, 150, 60, 60}).status, Status::kIndistinct) << "a piece of wall";
  EXPECT_EQ(learn_colour(scene({255, 240, 250}, 60, 3, 5), kAround).status, Status::kOverexposed);
  for (const Status status :
       {Status::kLearned, Status::kBadImage, Status::kTooSmall, Status::kOverexposed, Status::kIndistinct}) {
    EXPECT_STRNE(description(status), "");
  }
}

TEST(LearnColour, WorksWithoutARest) {
  cv::Mat image(40, 40, CV_8UC3, cv::Scalar(110, 40, 220));
  const LearnedColour learned = learn_colour(image, {0, 0, 40, 40});
  ASSERT_EQ(learned.status, LearnedColour::Status::kLearned);
  EXPECT_EQ(learned.background, 0);
  EXPECT_EQ(largest(learned, image).area, 1600 - 4) << "the opening takes the corners";
}

TEST(LearnColour, FindsTheSolidsOfAPhotographInBothViews) {
  const std::string folder = std::string(MULTIREACH_SHARED_DIR) + "/data/moebius/";
  if (!std::filesystem::exists(folder + "view1.png")) GTEST_SKIP() << folder << " is not there";
  const cv::Mat left = cv::imread(folder + "view1.png"), right = cv::imread(folder + "view5.png");
  // Rectangles in the left image, drawn by hand: the pink solid, the red star, the red solid, a blue solid.
  for (const cv::Rect& rectangle :
       {cv::Rect(198, 222, 66, 58), cv::Rect(75, 175, 92, 78), cv::Rect(212, 22, 80, 62), cv::Rect(308, 303, 58, 55)}) {
    const LearnedColour learned = learn_colour(left, rectangle);
    ASSERT_EQ(learned.status, LearnedColour::Status::kLearned);
    EXPECT_GT(learned.kept, 0.75);
    EXPECT_LT(learned.background, 0.04) << "other things of that colour are in the picture";
    const Blob here = largest(learned, left), there = largest(learned, right);
    EXPECT_GT((here.box & rectangle).area(), 0.85 * here.box.area()) << rectangle;
    // The images are rectified: the object is in the same rows of the right image, farther to the left.
    EXPECT_NEAR(here.centroid.y(), there.centroid.y(), 4) << rectangle;
    EXPECT_GT(here.centroid.x(), there.centroid.x()) << rectangle;
    EXPECT_NEAR(there.area / here.area, 1, 0.25) << rectangle;
  }
}

TEST(LearnColour, SaysWhichPictureIsOfNoUse) {
  const cv::Mat image = scene({40, 90, 180}, 150, 1, 3);
  const TrainingPicture good{.bgr = image, .rectangle = kAround}, none{.bgr = image, .has_object = false};
  const TrainingPicture grey{.bgr = cv::Mat(50, 50, CV_8UC1), .rectangle = {5, 5, 20, 20}};
  EXPECT_EQ(learn_colour(std::vector<TrainingPicture>{}).status, LearnedColour::Status::kNoObject);
  EXPECT_EQ(learn_colour(std::vector{none}).status, LearnedColour::Status::kNoObject);
  const LearnedColour learned = learn_colour(std::vector{good, grey});
  EXPECT_EQ(learned.status, LearnedColour::Status::kBadImage);
  EXPECT_EQ(learned.picture, size_t{1});
}

TEST(LearnColour, GivesUpTheDarkestPartForColouredEdgesOfDarkThings) {
  // A disc whose lowest twelfth is nearly black, and a black cloth with edges of the disc's chroma, as lenses leave
  // them: as dark as that part. A narrow strip is no other object of this colour.
  cv::Mat image(kHeight, kWidth, CV_8UC3, cv::Scalar(150, 150, 150)), mask = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  cv::circle(mask, kCentre, kRadius, cv::Scalar(255), cv::FILLED);
  cv::rectangle(image, {220, 20, 60, 200}, cv::Scalar(12, 12, 12), cv::FILLED);
  const cv::Rect edges[]{{216, 20, 4, 200}, {280, 20, 4, 200}};
  for (const cv::Rect& edge : edges) cv::rectangle(image, edge, cv::Scalar(4, 12, 28), cv::FILLED);
  const int dark = kCentre.y + kRadius * 3 / 4;
  image.setTo(cv::Scalar(32, 96, 224), mask);
  image.rowRange(dark, kHeight).setTo(cv::Scalar(4, 12, 28), mask.rowRange(dark, kHeight));
  const LearnedColour learned = learn_colour_of(image, mask);
  ASSERT_EQ(learned.status, LearnedColour::Status::kLearned);
  BlobFinder finder;
  const FoundBlobs found = finder.find(image, {0, 0, kWidth, kHeight}, ColourTable(learned.model));
  ASSERT_EQ(found.blobs.size(), 1U);
  EXPECT_NEAR(found.blobs[0].centroid.x(), kCentre.x, 1);
  EXPECT_GT(learned.kept, 0.85);
}

TEST(LearnColour, IsNotCutByTheObjectsOtherPatches) {
  // A disc of two patches with a grey band between them, of which a click proposes the upper one. The lower one, in
  // other light, is partly of its colours, and partly paler: it is not taken for another thing that must not be found.
  cv::Mat image(kHeight, kWidth, CV_8UC3, cv::Scalar(150, 150, 150)), disc = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  cv::circle(disc, kCentre, kRadius, cv::Scalar(255), cv::FILLED);
  const int above = kCentre.y - 4, below = kCentre.y + 6;
  for (int column = 0; column < kWidth; ++column) {
    const double pale = std::clamp((column - kCentre.x + kRadius) / (2.0 * kRadius), 0.0, 1.0);
    const auto paint = [&](int first, int end, double paleness) {
      const cv::Range rows(first, end), columns(column, column + 1);
      image(rows, columns).setTo(cv::Scalar(32 + 70 * paleness, 96, 224 - 60 * paleness), disc(rows, columns));
    };
    paint(0, above, pale);
    paint(below, kHeight, 0.5 + pale);
  }
  cv::Mat upper = disc.clone();
  upper.rowRange(above, kHeight).setTo(0);
  EXPECT_GT(learn_colour_of(image, upper).kept, 0.9);
}

TEST(LearnColour, AnotherPictureTellsWhatIsMoreOfTheObject) {
  // A disc that becomes paler from the left to the right: one picture shows all of it, and in the other one a click
  // proposes the right quarter only. The rest is not taken for something that must not be found with it.
  cv::Mat image(kHeight, kWidth, CV_8UC3, cv::Scalar(150, 150, 150)), disc = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  cv::circle(disc, kCentre, kRadius, cv::Scalar(255), cv::FILLED);
  for (int column = 0; column < kWidth; ++column) {
    const double pale = std::clamp((column - kCentre.x + kRadius) / (2.0 * kRadius), 0.0, 1.0);
    image.col(column).setTo(cv::Scalar(30 + 50 * pale, 60 + 50 * pale, 200), disc.col(column));
  }
  cv::Mat part = disc.clone();
  part.colRange(0, kCentre.x + kRadius / 2).setTo(0);
  const LearnedColour learned =
      learn_colour(std::vector<TrainingPicture>{{.bgr = image, .mask = disc}, {.bgr = image, .mask = part}});
  ASSERT_EQ(learned.status, LearnedColour::Status::kLearned);
  EXPECT_GT(learned.rates[0].kept, 0.9);
  EXPECT_GT(learned.rates[1].kept, 0.9);
}

TEST(LearnColour, ASmallChangeOfTheLightDoesNotMakeTheWallTheObject) {
  // A disc of glass: through its right part, the wall is seen, which has a little of its hue.
  const cv::Vec3d vivid(30, 110, 225), grey(150, 150, 150);
  for (const double hue : {0.04, 0.12, 0.2, 0.32, 0.36, 0.48}) {
    const cv::Vec3d wall = grey + hue * (vivid - grey);
    cv::Mat image(kHeight, kWidth, CV_8UC3, cv::Scalar(wall[0], wall[1], wall[2]));
    cv::Mat disc = cv::Mat::zeros(kHeight, kWidth, CV_8UC1), noise(kHeight, kWidth, CV_8UC3);
    cv::circle(disc, kCentre, kRadius, cv::Scalar(255), cv::FILLED);
    for (int column = 0; column < kWidth; ++column) {
      const double clear = 0.6 * std::clamp((column - kCentre.x + kRadius) / (2.0 * kRadius), 0.0, 1.0);
      const cv::Vec3d colour = vivid + clear * (wall - vivid);
      image.col(column).setTo(cv::Scalar(colour[0], colour[1], colour[2]), disc.col(column));
    }
    cv::RNG(7).fill(noise, cv::RNG::NORMAL, cv::Scalar::all(20), cv::Scalar::all(2));
    image += noise;
    LearnedColour learned = learn_colour_of(image, disc);
    ASSERT_EQ(learned.status, LearnedColour::Status::kLearned);
    EXPECT_GT(learned.kept, 0.8) << hue;
    learned.model.tolerance *= 1.2;
    EXPECT_LT(largest(learned, image).area, 10 * 3.14159 * kRadius * kRadius) << hue << ' ' << learned.model.tolerance;
  }
}

TEST(LearnColour, OnePictureOfSeveralMayBeOverexposed) {
  cv::Mat image(kHeight, kWidth, CV_8UC3, cv::Scalar(120, 120, 120)), mask = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  cv::circle(mask, kCentre, kRadius, cv::Scalar(255), cv::FILLED);
  image.setTo(cv::Scalar(30, 60, 200), mask);
  cv::Mat white = image.clone();
  white.setTo(cv::Scalar(255, 255, 255), mask);
  const TrainingPicture good{.bgr = image, .mask = mask}, overexposed{.bgr = white, .mask = mask};
  for (const std::vector<TrainingPicture>& pictures :
       {std::vector{good, overexposed}, {overexposed, good}, {good, overexposed, good}}) {
    const LearnedColour learned = learn_colour(pictures);
    ASSERT_EQ(learned.status, LearnedColour::Status::kLearned) << description(learned.status);
    EXPECT_LT((learned.model.object[0].mean - chroma_of({200, 60, 30})).norm(), 0.1);
  }
  EXPECT_EQ(learn_colour(std::vector{overexposed, overexposed}).status, LearnedColour::Status::kOverexposed);
}

}  // namespace
}  // namespace multireach::vision
