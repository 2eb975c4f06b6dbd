#include <gtest/gtest.h>

#include "runtime/channels.hpp"

namespace multireach::channel {
namespace {

TEST(ImageUrl, IsOnePortAboveTheControlGroup) {
  EXPECT_EQ(image_url_for(kControlUrl), kImageUrl) << "the default groups";
  EXPECT_EQ(image_url_for("udpm://239.1.2.3:5000?ttl=1"), "udpm://239.1.2.3:5001?ttl=1");
  EXPECT_EQ(image_url_for("udpm://239.1.2.3:5000"), "udpm://239.1.2.3:5001");
  EXPECT_EQ(image_url_for("udpm://239.1.2.3"), "udpm://239.1.2.3:7668") << "LCM's default port";
  EXPECT_EQ(image_url_for("udpm://?ttl=1"), "udpm://239.255.76.67:7668?ttl=1") << "LCM's default group";
  EXPECT_EQ(image_url_for("tcpq://localhost:7700"), "tcpq://localhost:7700") << "one server carries both";
}

}  // namespace
}  // namespace multireach::channel
