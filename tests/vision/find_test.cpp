#include "vision/colour/find.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <iostream>
#include <opencv2/imgproc.hpp>

#include "numeric/instruction_set.hpp"
#include "numeric/random.hpp"
#include "tests/allocation_count.hpp"
#include "vision/colour/colour_mask.hpp"

namespace multireach::vision {
namespace {

const cv::Vec3b kPink(110, 40, 220), kGrey(120, 121, 119);

ColourTable pink() {
  return ColourTable(model_of({.references = {{220, 40, 110}}, .tolerance = 0.55}));
}

/// A picture that is pink where the mask is set, and grey elsewhere.
cv::Mat painted(const cv::Mat& mask) {
  cv::Mat image(mask.size(), CV_8UC3, kGrey);
  image.setTo(kPink, mask);
  return image;
}

cv::Mat plain_mask(const cv::Mat& bgr, const ColourTable& colours) {
  cv::Mat mask(bgr.size(), CV_8UC1);
  for (int row = 0; row < bgr.rows; ++row) {
    for (int column = 0; column < bgr.cols; ++column) {
      const auto& pixel = bgr.at<cv::Vec3b>(row, column);
      mask.at<uint8_t>(row, column) = colours.contains(pixel[0], pixel[1], pixel[2]) ? 255 : 0;
    }
  }
  return mask;
}

/// Reference implementation: looks every pixel up in the table, and gets the connected components from OpenCV.
std::vector<Blob> plain_find(const cv::Mat& bgr, const cv::Rect& part, const ColourTable& colours, double min_area,
                             bool opened) {
  cv::Mat mask = plain_mask(bgr(part), colours), labels, stats, centroids;
  if (opened) {
    const cv::Mat cross = cv::getStructuringElement(cv::MORPH_CROSS, {3, 3});
    cv::morphologyEx(mask, mask, cv::MORPH_OPEN, cross, {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  }
  const int labelled = cv::connectedComponentsWithStats(mask, labels, stats, centroids, 8);
  std::vector<Blob> blobs(static_cast<size_t>(labelled));
  for (int row = 0; row < part.height; ++row) {
    for (int column = 0; column < part.width; ++column) {
      std::vector<Run>& runs = blobs[static_cast<size_t>(labels.at<int>(row, column))].runs;
      const Run pixel{row + part.y, column + part.x, column + part.x + 1};
      if (!runs.empty() && runs.back().row == pixel.row && runs.back().end == pixel.begin) {
        ++runs.back().end;
      } else {
        runs.push_back(pixel);
      }
    }
  }
  std::vector<Blob> result;
  for (int label = 1; label < labelled; ++label) {
    Blob& blob = blobs[static_cast<size_t>(label)];
    const int* stat = stats.ptr<int>(label);
    blob.area = stat[cv::CC_STAT_AREA];
    if (blob.area < min_area) continue;
    blob.box = {stat[cv::CC_STAT_LEFT] + part.x, stat[cv::CC_STAT_TOP] + part.y, stat[cv::CC_STAT_WIDTH],
                stat[cv::CC_STAT_HEIGHT]};
    blob.centroid = {centroids.at<double>(label, 0) + part.x, centroids.at<double>(label, 1) + part.y};
    for (const Run& run : blob.runs) {
      for (int column = run.begin; column < run.end; ++column) {
        const Eigen::Vector2d from = Eigen::Vector2d(column, run.row) - blob.centroid;
        blob.spread += from * from.transpose() / blob.area;
      }
    }
    result.push_back(std::move(blob));
  }
  std::ranges::sort(result, [](const Blob& a, const Blob& b) {
    if (a.area != b.area) return a.area > b.area;
    return std::pair(a.runs[0].row, a.runs[0].begin) < std::pair(b.runs[0].row, b.runs[0].begin);
  });
  return result;
}

void expect_same(const cv::Mat& bgr, const cv::Rect& part, double min_area, bool opened, const std::string& what) {
  const ColourTable colours = pink();
  BlobFinder finder;
  const FoundBlobs found = finder.find(bgr, part, colours, {.min_area = min_area, .most = 1 << 20, .opened = opened});
  const std::vector<Blob> expected = plain_find(bgr, part, colours, min_area, opened);
  EXPECT_FALSE(found.too_many_runs) << what;
  EXPECT_EQ(found.members, cv::countNonZero(plain_mask(bgr(part), colours))) << what;
  ASSERT_EQ(found.blobs.size(), expected.size()) << what;
  for (size_t i = 0; i < expected.size(); ++i) {
    const Blob &blob = found.blobs[i], &truth = expected[i];
    ASSERT_EQ(blob.runs, truth.runs) << what << ", blob " << i;
    ASSERT_EQ(blob.box, truth.box) << what;
    ASSERT_EQ(blob.area, truth.area) << what;
    ASSERT_LT((blob.centroid - truth.centroid).norm(), 1e-9) << what;
    ASSERT_LT((blob.spread - truth.spread).norm(), 1e-8 * (1 + truth.spread.norm())) << what;
  }
}

/// Calls `check` for each instruction set of this processor.
void on_every_instruction_set(const std::function<void(const std::string&)>& check) {
  for (const std::string& name : available_instruction_sets()) {
    ASSERT_TRUE(select_instruction_set(name));
    check(name);
  }
  select_instruction_set("");
}

cv::Mat random_mask(uint64_t seed, int width, int height, double density) {
  const CounterRandom random(seed);
  cv::Mat mask(height, width, CV_8UC1);
  for (int i = 0; i < width * height; ++i) mask.data[i] = random.uniform(static_cast<uint64_t>(i)) < density ? 255 : 0;
  return mask;
}

/// Discs, rings, spirals and combs: their parts join into one component only in late rows.
cv::Mat shapes(uint64_t seed, int width, int height) {
  cv::Mat mask(height, width, CV_8UC1, cv::Scalar(0));
  const CounterRandom random(seed);
  uint64_t counter = 0;
  const auto at = [&](int limit) { return static_cast<int>(random.uniform(counter++, 0, limit)); };
  for (int i = 0; i < 12; ++i) {
    const cv::Point centre(at(width), at(height));
    cv::circle(mask, centre, 1 + at(20), 255, i % 3 == 0 ? 1 : -1);
    cv::line(mask, centre, {at(width), at(height)}, 255, 1);
  }
  for (int column = 0; column < width / 2; column += 2) cv::line(mask, {column, height / 2}, {column, height - 1}, 255);
  cv::line(mask, {0, height - 1}, {width / 2, height - 1}, 255);
  return mask;
}

TEST(Find, IsWhatATableAndOpenCvComponentsGive) {
  std::cout << "seeds 1 to 60\n";
  on_every_instruction_set([](const std::string& name) {
    uint64_t seed = 1;
    for (const double density : {0.02, 0.3, 0.6, 0.98}) {
      for (const int width : {1, 2, 7, 15, 16, 17, 31, 63, 64, 65, 100, 127, 128, 129, 200}) {
        const cv::Mat image = painted(random_mask(seed++, width, 23, density));
        for (const bool opened : {false, true})
          expect_same(image, {0, 0, width, 23}, 1, opened, name + ", width " + std::to_string(width));
      }
    }
    for (seed = 1; seed <= 20; ++seed) {
      const cv::Mat image = painted(shapes(seed, 203, 91));
      for (const bool opened : {false, true})
        expect_same(image, {0, 0, 203, 91}, 1, opened, name + ", shapes " + std::to_string(seed));
      for (const bool opened : {false, true})
        expect_same(image, {11, 5, 131, 70}, 20, opened, name + ", a part of shapes " + std::to_string(seed));
    }
  });
}

TEST(Find, PixelsOfAllColoursAreClassifiedAlike) {
  const CounterRandom random(3);
  std::cout << "seed 3\n";
  cv::Mat image(60, 333, CV_8UC3);
  for (int i = 0; i < 3 * 60 * 333; ++i) image.data[i] = static_cast<uint8_t>(random.bits(static_cast<uint64_t>(i)));
  const ColourTable colours = pink();
  on_every_instruction_set([&](const std::string& name) {
    std::vector<uint64_t> words(words_for(image.cols));
    for (int row = 0; row < image.rows; ++row) {
      const int members = colour_mask_row(colours, image.ptr(row), image.cols, words.data());
      int counted = 0;
      for (const uint64_t word : words) counted += std::popcount(word);
      ASSERT_EQ(members, counted) << name;
      for (int column = 0; column < image.cols; ++column) {
        const auto& pixel = image.at<cv::Vec3b>(row, column);
        ASSERT_EQ(words[static_cast<size_t>(column) / 64] >> (column % 64) & 1,
                  colours.contains(pixel[0], pixel[1], pixel[2]) ? 1U : 0U)
            << name << ", pixel " << column << ", " << row;
      }
      ASSERT_EQ(words.back() >> (image.cols % 64), 0U) << "bits beyond the row";
    }
  });
}

TEST(Find, NoMemberIsOutsideOfTheBoxes) {
  const auto in_boxes = [](const ColourBoxes& boxes, int r, int g, int b) {
    return (boxes.red[static_cast<size_t>(r) >> 4] & boxes.green[static_cast<size_t>(g) >> 4] &
            boxes.blue[static_cast<size_t>(b) >> 4]) != 0;
  };
  for (const Rgb& reference : {Rgb{220, 40, 110}, Rgb{30, 200, 60}, Rgb{250, 240, 10}, Rgb{90, 100, 110}}) {
    const ColourTable colours(model_of({.references = {reference}, .tolerance = 0.4}));
    int members = 0, candidates = 0;
    for (int r = 0; r < 256; ++r) {
      for (int g = 0; g < 256; ++g) {
        for (int b = 0; b < 256; ++b) {
          const bool member =
              colours.contains(static_cast<uint8_t>(b), static_cast<uint8_t>(g), static_cast<uint8_t>(r));
          const bool candidate = in_boxes(colours.boxes(), r, g, b);
          ASSERT_LE(member, candidate) << r << " " << g << " " << b;
          members += member ? 1 : 0;
          candidates += candidate ? 1 : 0;
        }
      }
    }
    EXPECT_GT(members, 10000);
    EXPECT_LT(candidates, 6 * members) << "boxes that are no help";
  }
}

TEST(Find, GivesTheLargestFirstAndNotMoreThanAsked) {
  cv::Mat mask(100, 200, CV_8UC1, cv::Scalar(0));
  mask(cv::Rect(5, 5, 8, 8)).setTo(255);
  mask(cv::Rect(50, 20, 20, 20)).setTo(255);
  mask(cv::Rect(100, 60, 10, 10)).setTo(255);
  mask(cv::Rect(150, 60, 10, 10)).setTo(255);
  mask(cv::Rect(190, 90, 5, 5)).setTo(255);
  BlobFinder finder;
  const FoundBlobs found = finder.find(painted(mask), {0, 0, 200, 100}, pink(), {.min_area = 30, .most = 3});
  ASSERT_EQ(found.blobs.size(), 3U);
  EXPECT_EQ(found.members, 400 + 200 + 64 + 25);
  EXPECT_EQ(found.blobs[0].box, cv::Rect(50, 20, 20, 20));
  EXPECT_EQ(found.blobs[1].box, cv::Rect(100, 60, 10, 10)) << "of equal ones that which begins earlier";
  EXPECT_EQ(found.blobs[2].box, cv::Rect(150, 60, 10, 10));
  EXPECT_TRUE(found.blobs[0].centroid.isApprox(Eigen::Vector2d(59.5, 29.5)));
  EXPECT_EQ(found.blobs[0].area, 396) << "the cross takes the corners";
}

TEST(Find, OfAPartOutsideOfTheImageIsNothing) {
  const cv::Mat image = painted(cv::Mat(40, 50, CV_8UC1, cv::Scalar(255)));
  BlobFinder finder;
  EXPECT_TRUE(finder.find(image, {60, 0, 10, 10}, pink()).blobs.empty());
  EXPECT_TRUE(finder.find(image, {0, 0, 0, 0}, pink()).blobs.empty());
  EXPECT_TRUE(finder.find(cv::Mat(40, 50, CV_8UC1), {0, 0, 50, 40}, pink()).blobs.empty()) << "no BGR";
  const FoundBlobs found = finder.find(image, {-10, 30, 30, 30}, pink());
  ASSERT_EQ(found.blobs.size(), 1U);
  EXPECT_EQ(found.blobs[0].box, cv::Rect(0, 30, 20, 10));
}

TEST(Find, AllPixelsAreOneBlob) {
  const cv::Mat image = painted(cv::Mat(480, 640, CV_8UC1, cv::Scalar(255)));
  BlobFinder finder;
  const FoundBlobs found = finder.find(image, {0, 0, 640, 480}, pink());
  ASSERT_EQ(found.blobs.size(), 1U);
  EXPECT_EQ(found.blobs[0].area, 640 * 480 - 4) << "the corners";
  EXPECT_EQ(found.members, 640 * 480);
}

TEST(Find, AColourAllOverThePlaceIsCrowded) {
  cv::Mat mask(480, 640, CV_8UC1);
  for (int row = 0; row < 480; ++row) {
    for (int column = 0; column < 640; ++column) mask.at<uint8_t>(row, column) = (row + column) % 2 ? 255 : 0;
  }
  BlobFinder finder;
  const FoundBlobs found = finder.find(painted(mask), {0, 0, 640, 480}, pink(), {.opened = false});
  EXPECT_TRUE(found.too_many_runs);
  EXPECT_TRUE(found.blobs.empty());
  // A quarter of the image is not too crowded, and is one component, because the pixels touch at their corners.
  const FoundBlobs half = finder.find(painted(mask), {0, 0, 320, 240}, pink(), {.opened = false});
  EXPECT_FALSE(half.too_many_runs);
  ASSERT_EQ(half.blobs.size(), 1U);
  EXPECT_EQ(half.blobs[0].area, 320 * 240 / 2);
  const FoundBlobs opened = finder.find(painted(mask), {0, 0, 640, 480}, pink());
  EXPECT_TRUE(opened.blobs.empty());
  EXPECT_FALSE(opened.too_many_runs);
  EXPECT_EQ(opened.members, 640 * 480 / 2);
}

TEST(Find, KeepsItsMemory) {
  std::vector<cv::Mat> images;
  for (uint64_t seed = 1; seed <= 8; ++seed) images.push_back(painted(shapes(seed, 96, 48)));
  images.push_back(painted(random_mask(9, 96, 48, 0.3)));
  const ColourTable colours = pink();
  BlobFinder finder;
  const auto frames = [&](int number) {
    int64_t members = 0;
    for (int i = 0; i < number; ++i) {
      members += finder.find(images[static_cast<size_t>(i) % images.size()], {0, 0, 96, 48}, colours).members;
    }
    return members;
  };
  frames(100);
  const testing::AllocationCount before = testing::allocations();
  EXPECT_GT(frames(100000), 0);
  EXPECT_EQ(testing::allocations().number, before.number);
}

}  // namespace
}  // namespace multireach::vision
