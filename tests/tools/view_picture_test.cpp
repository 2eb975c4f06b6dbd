#include <gtest/gtest.h>

#include <filesystem>
#include <multireach/debug_request_t.hpp>
#include <multireach/images_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/files.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/view/picture_node.hpp"

namespace multireach {
namespace {

class Picture : public ::testing::Test {
 protected:
  static std::vector<uint8_t> message(const std::vector<uint8_t>& data, int32_t format = image_t::PIXEL_FORMAT_MJPEG) {
    images_t images;
    images.utime = 1;
    images.n_images = 1;
    images.image_types = {images_t::LEFT};
    images.images.resize(1);
    images.images[0] = image_t{};
    images.images[0].pixelformat = format;
    images.images[0].size = static_cast<int32_t>(data.size());
    images.images[0].data = data;
    return *encode(images);
  }
  void receive(const std::vector<uint8_t>& bytes) { node_.receive(channel::kVisionDebug, bytes, out_); }

  const testing::TemporaryFolder folder_;
  const std::string path_ = folder_ / "picture.jpg";
  PictureNode node_{path_, 5000000};
  Outbox out_;
};

TEST_F(Picture, AsksOnceASecond) {
  for (int i = 0; i < 12; ++i) node_.tick(out_);
  ASSERT_EQ(out_.size(), 3U);
  for (size_t i = 0; i < out_.size(); ++i) {
    EXPECT_EQ(out_[i].channel, channel::kVisionDebugRequest);
    const auto request = decode<debug_request_t>(out_[i].bytes);
    ASSERT_TRUE(request);
    EXPECT_EQ(request->utime, 5000000 + static_cast<int64_t>(i) * 1000000);
  }
}

TEST_F(Picture, KeepsTheNewest) {
  const std::vector<uint8_t> first{0xff, 0xd8, 1, 2}, second{0xff, 0xd8, 3, 4, 5};
  node_.tick(out_);
  EXPECT_FALSE(std::filesystem::exists(path_));
  receive(message(first));
  receive(message(second));
  node_.tick(out_);
  EXPECT_EQ(read_binary_file(path_), second);
  receive(message(first));
  node_.flush();
  EXPECT_EQ(read_binary_file(path_), first);
  EXPECT_EQ(node_.pictures(), 3);
}

TEST_F(Picture, RefusesWhatIsNoPicture) {
  receive({1, 2, 3});
  receive(message({1, 2, 3, 4}));
  receive(message({0xff, 0xd8, 1, 2}, image_t::PIXEL_FORMAT_BGR));
  receive(message({}));
  node_.tick(out_);
  EXPECT_EQ(node_.counters().refused, 4);
  EXPECT_EQ(node_.pictures(), 0);
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(Picture, SaysWhenItCannotBeWritten) {
  PictureNode node("/nowhere/picture.jpg", 0);
  node.receive(channel::kVisionDebug, message({0xff, 0xd8, 1, 2}), out_);
  EXPECT_THROW(node.flush(), InputError);
}

}  // namespace
}  // namespace multireach
