// Imports of recordings, and exports: pixels, times and pairs.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <multireach/images_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/image_file.hpp"
#include "runtime/image_message.hpp"
#include "tests/tools/recordings.hpp"
#include "tools/log/export.hpp"

namespace multireach {
namespace {

TEST_F(LogImport, AFolderWithTimesGivesTheSessionThatItWasMadeOf) {
  std::string table = "time_s,left,right\n";
  for (size_t i = 0; i < pairs_.size(); ++i) {
    char line[100];
    std::snprintf(line, sizeof line, " %lld.%06lld , l/%zu.jpg,r/%zu.jpg\r\n",
                  static_cast<long long>(pairs_[i].utime / 1000000), static_cast<long long>(pairs_[i].utime % 1000000),
                  i, i);
    table += line;
    written("in/l/" + std::to_string(i) + ".jpg", data_of(pairs_[i].images[0]));
    written("in/r/" + std::to_string(i) + ".jpg", data_of(pairs_[i].images[1]));
  }
  written("in/pairs.csv", table + "\n");
  const ImportSummary summary = import(path("in"));
  EXPECT_EQ(summary.pairs, static_cast<int64_t>(kPairs));
  EXPECT_EQ(summary.unpaired, 0);
  EXPECT_EQ(summary.period_us, 33333);
  EXPECT_EQ(summary.width, 320);
  EXPECT_EQ(summary.text().substr(0, 27), "20 pairs of 320 x 240 pixel");
  expect_the_same_pairs();
}

TEST_F(LogImport, FaultsOfAFolderNameFileLineAndWhatWasExpected) {
  const auto said = [&](const std::string& table) {
    written("in/pairs.csv", table);
    return import_fault(path("in"));
  };
  written("in/a.jpg", data_of(pairs_[0].images[0]));
  const std::string file = path("in/pairs.csv");
  EXPECT_EQ(said("time,left,right\n"),
            file +
                ":1: 'time,left,right' are not the names of the columns; expected time_s,left,right or "
                "time_s,left,right,right_time_s");
  EXPECT_EQ(said("time_s,left,right\n1,a.jpg\n"), file + ":2: has 2 values; expected 3: time_s,left,right");
  for (const char* time : {"x", "-1", "1e3", "1.2.3", ".5", "", "99999999999999999999"})
    EXPECT_NE(said(std::string("time_s,left,right\n\n") + time + ",a.jpg,a.jpg\n").find(":3: '"), std::string::npos);
  EXPECT_NE(said("time_s,left,right\n1,a.jpg,a.jpg\n1,a.jpg,a.jpg\n").find(":3: the time 1 is not after"),
            std::string::npos);
  EXPECT_NE(said("time_s,left,right\n1,a.jpg,b.jpg\n").find("b.jpg: cannot be opened"), std::string::npos);
  EXPECT_NE(said("time_s,left,right\n1,a.jpg,pairs.csv\n").find("pairs.csv: is not an image"), std::string::npos);
  EXPECT_NE(said("time_s,left,right\n").find("has no image"), std::string::npos);
  EXPECT_NE(said("time_s,left,right,right_time_s\n1,a.jpg,a.jpg,2\n").find("are at most 0.5 s apart"),
            std::string::npos);
  options_.max_skew_s = 2;
  EXPECT_EQ(said("time_s,left,right,right_time_s\n1,a.jpg,a.jpg,2\n"), "");
  EXPECT_FALSE(std::filesystem::exists(path("other.lcm")));
  std::filesystem::create_directory(path("empty"));
  EXPECT_NE(import_fault(path("empty")).find("expected pairs.csv in it"), std::string::npos);
  EXPECT_NE(import_fault(path("nowhere")).find("nowhere: cannot be opened"), std::string::npos);
  EXPECT_NE(import_fault(written("text.bag", "text")).find("expected a bag of ROS 1"), std::string::npos);
}

TEST_F(LogImport, AnEurocRecordingGivesItsPixelsAndPairsByTime) {
  // Two free-running cameras at 20 Hz: the right one 4 ms later, without its third image.
  constexpr int64_t kBegin = 1403636579758555392;  // ns
  std::string left = "#timestamp [ns],filename\n", right = left;
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < 6; ++i) {
    cv::Mat picture(10, 16, CV_8UC1);
    for (int p = 0; p < 160; ++p) picture.data[p] = static_cast<uint8_t>(p + 40 * i);
    const auto png = encode_png(picture);
    const std::string bytes(png.begin(), png.end());
    const std::string name = std::to_string(kBegin + i * 50000000);
    left += name + "," + name + ".png\n";
    written("mh/mav0/cam0/data/" + name + ".png", bytes);
    const std::string later = std::to_string(kBegin + i * 50000000 + 4000000);
    if (i != 2) right += later + "," + later + ".png\n";
    written("mh/mav0/cam1/data/" + later + ".png", bytes);
    pictures.push_back(picture);
  }
  written("mh/mav0/cam0/data.csv", left);
  written("mh/mav0/cam1/data.csv", right);
  options_ = {};
  options_.jpeg_quality = 0;
  for (const char* input : {"mh", "mh/mav0"}) {
    const ImportSummary summary = import(path(input));
    EXPECT_EQ(summary.pairs, 5);
    EXPECT_EQ(summary.unpaired, 1);
    EXPECT_EQ(summary.period_us, 50000);
    EXPECT_EQ(summary.median_skew_us, 4000);
    const std::vector<images_t> pairs = session();
    ASSERT_EQ(pairs.size(), 5U);
    EXPECT_EQ(pairs[2].utime, kBegin / 1000 + 3 * 50000);
    EXPECT_EQ(pairs[2].images[1].utime, kBegin / 1000 + 3 * 50000 + 4000);
    ImageCodec codec;
    cv::Mat bgr;
    for (const image_t& image : pairs[2].images) {
      ASSERT_TRUE(codec.decode(encoded(image), bgr));
      for (int p = 0; p < 160; ++p) ASSERT_EQ(bgr.data[3 * p + 1], pictures[3].data[p]) << p;
    }
  }
  written("mh/mav0/cam1/data.csv", "#timestamp [ns],filename\n12x,a.png\n");
  EXPECT_EQ(import_fault(path("mh")), path("mh/mav0/cam1/data.csv") + ":2: '12x' is not a time; expected nanoseconds");
  options_.right = "cam7";
  EXPECT_NE(import_fault(path("mh")).find("cam7/data.csv: cannot be opened"), std::string::npos);
}

TEST_F(LogImport, McapFilesGiveTheSessionThatTheyWereMadeOf) {
  for (const char* compression : {"", "lz4", "zstd"}) {
    SCOPED_TRACE(compression);
    const ImportSummary summary = import(written("run.mcap", recorded_mcap(compression)));
    EXPECT_EQ(summary.pairs, static_cast<int64_t>(kPairs));
    EXPECT_EQ(summary.unpaired, 0);
    EXPECT_EQ(summary.warning, "");
    expect_the_same_pairs();
  }
}

TEST_F(LogImport, BagsGiveTheSessionThatTheyWereMadeOf) {
  for (const char* compression : {"none", "bz2", "lz4"}) {
    SCOPED_TRACE(compression);
    const ImportSummary summary = import(written("run.bag", recorded_bag(compression)));
    EXPECT_EQ(summary.pairs, static_cast<int64_t>(kPairs));
    EXPECT_EQ(summary.unpaired, 0);
    EXPECT_EQ(summary.warning, "");
    expect_the_same_pairs();
  }
}

// Export's oracle is import, which the tests above compare with files laid out by hand; tests/live/import.sh reads an
// exported bag by ROS's own library.
TEST_F(LogImport, ExportedSessionsGiveTheSessionAgain) {
  const std::string exported = path("exported.lcm");
  {
    LogWriter log(exported);
    for (const images_t& pair : pairs_) log.write(pair.utime, channel::kStereoImages, *encode(pair));
    log.close();
  }
  std::vector<std::string> warnings;
  EXPECT_EQ(export_pairs(exported, path("pairs"), warnings), static_cast<int64_t>(kPairs));
  EXPECT_EQ(import(path("pairs")).pairs, static_cast<int64_t>(kPairs));
  expect_the_same_pairs();
  EXPECT_EQ(export_bag(exported, path("exported.bag"), warnings), static_cast<int64_t>(kPairs));
  options_.left = "/left/image_raw/compressed";
  options_.right = "/right/image_raw/compressed";
  import(path("exported.bag"));
  expect_the_same_pairs();

  EXPECT_EQ(export_euroc(exported, path("euroc"), warnings), static_cast<int64_t>(kPairs));
  options_.left = options_.right = "";
  options_.jpeg_quality = 0;
  EXPECT_EQ(import(path("euroc")).pairs, static_cast<int64_t>(kPairs));
  ImageCodec codec;
  cv::Mat expected, imported;
  const std::vector<images_t> again = session();
  ASSERT_EQ(again.size(), kPairs);
  for (size_t i = 0; i < kPairs; ++i) {
    for (size_t side = 0; side < 2; ++side) {
      ASSERT_TRUE(codec.decode(encoded(pairs_[i].images[side]), expected));
      ASSERT_TRUE(codec.decode(encoded(again[i].images[side]), imported));
      EXPECT_EQ(cv::norm(expected, imported, cv::NORM_INF), 0) << i;
      EXPECT_EQ(again[i].images[side].utime, pairs_[i].images[side].utime);
    }
  }
  EXPECT_TRUE(warnings.empty());
}

TEST_F(LogImport, ExportNamesWhatItLeavesOut) {
  const std::string exported = path("exported.lcm");
  images_t lonely = pairs_[1];
  lonely.images.resize(1);
  lonely.image_types.resize(1);
  lonely.n_images = 1;
  {
    LogWriter log(exported);
    log.write(1, channel::kStereoImages, *encode(pairs_[0]));
    log.write(2, channel::kStereoImages, *encode(lonely));
    log.close();
  }
  std::vector<std::string> warnings;
  EXPECT_EQ(export_bag(exported, path("exported.bag"), warnings), 1);
  ASSERT_EQ(warnings.size(), 1);
  EXPECT_EQ(warnings[0], "event 1: has no left or no right image; left out");
}

TEST_F(LogImport, RawImagesOfRosKeepTheirPixels) {
  // 4 x 2 pixels in rows of 20 bytes: red 10 x + y, green 200, blue 100 + x.
  const auto pixels = [](const std::string& order) {
    std::string data;
    for (int y = 0; y < 2; ++y) {
      std::string row;
      for (int x = 0; x < 4; ++x) {
        for (const char c : order)
          row.push_back(static_cast<char>(c == 'r' ? 10 * x + y : c == 'g' ? 200 : c == 'b' ? 100 + x : 255));
      }
      data += row + std::string(20 - row.size(), '\0');
    }
    return data;
  };
  options_.jpeg_quality = 0;
  for (const auto& [encoding, order] :
       {std::pair("rgb8", "rgb"), {"bgr8", "bgr"}, {"rgba8", "rgba"}, {"bgra8", "bgra"}, {"mono8", "r"}}) {
    SCOPED_TRACE(encoding);
    std::string records = connection(0, "/left", "sensor_msgs/Image") + connection(1, "/right", "sensor_msgs/Image");
    for (uint32_t side = 0; side < 2; ++side)
      records += bag_message(side, 5000000, ros1_raw(5000000, 4, 2, encoding, 20, pixels(order)));
    import(written("raw.bag", bag(bag_chunk(records, "none"))));
    const images_t pair = session().at(0);
    ImageCodec codec;
    cv::Mat bgr;
    ASSERT_TRUE(codec.decode(encoded(pair.images[1]), bgr));
    for (int y = 0; y < 2; ++y) {
      for (int x = 0; x < 4; ++x) {
        const bool grey = std::string(encoding) == "mono8";
        const cv::Vec3b red_level(static_cast<uint8_t>(10 * x + y), static_cast<uint8_t>(10 * x + y),
                                  static_cast<uint8_t>(10 * x + y));
        const cv::Vec3b colour(static_cast<uint8_t>(100 + x), 200, static_cast<uint8_t>(10 * x + y));
        EXPECT_EQ(bgr.at<cv::Vec3b>(y, x), grey ? red_level : colour) << x << " " << y;
      }
    }
  }
}

}  // namespace
}  // namespace multireach
