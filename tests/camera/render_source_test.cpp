#include "camera/node/render_source.hpp"

#include <gtest/gtest.h>

#include <multireach/images_t.hpp>

#include "runtime/channels.hpp"
#include "tests/runtime/node_messages.hpp"

namespace multireach {
namespace {

// A renderer that is too slow for its scene must not send images of ever longer ago: it leaves some out, and each that
// it sends is the one of its time.
TEST(RenderSource, LatePairsAreLeftOutAndTheOthersStayTheSame) {
  const auto camera = [](LateTicks late) {
    return CameraNode(std::make_unique<RenderSource>(MULTIREACH_SOURCE_DIR "/logs/reach.yaml"), late);
  };
  CameraNode all = camera(LateTicks::kCompute), late = camera(LateTicks::kSkip);
  EXPECT_EQ(late.late_ticks(), LateTicks::kSkip);
  const auto pair_of = [](CameraNode& node) {
    Outbox out;
    node.tick(out);
    return testing::last_of<images_t>(out, channel::kStereoImages);
  };
  pair_of(late);
  const auto due = late.next_tick();
  late.skip_ticks(2);
  EXPECT_EQ(*late.next_tick(), *due + 66667) << "two of 30 Hz, in whole microseconds";
  images_t expected;
  for (int k = 0; k < 4; ++k) expected = pair_of(all);
  const images_t found = pair_of(late);
  EXPECT_EQ(found.utime, expected.utime);
  for (size_t side = 0; side < 2; ++side) EXPECT_EQ(found.images[side].data, expected.images[side].data);
  EXPECT_EQ(found.images[0].metadata[0].value[0], '1') << "its number is that of the pairs sent: none is lost";

  late.skip_ticks(100000);
  Outbox out;
  late.tick(out);
  EXPECT_TRUE(out.empty());
  EXPECT_TRUE(late.finished()) << "beyond the end of the scene";
}

}  // namespace
}  // namespace multireach
