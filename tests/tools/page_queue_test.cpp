#include <gtest/gtest.h>

#include <thread>

#include "tools/page/outgoing_queue.hpp"

namespace multireach {
namespace {

using Kind = Outgoing::Kind;

Outgoing outgoing(Kind kind, const std::string& text) {
  return {kind, std::make_shared<const std::string>(text)};
}

std::string next(OutgoingQueue& queue) {
  const auto found = queue.pop();
  return found ? *found->bytes : "closed";
}

TEST(PageQueue, ABrowserThatLagsLosesOldFramesAndIsToldToGetAllAgain) {
  OutgoingQueue queue;
  for (int i = 0; i < 100; ++i) queue.push(outgoing(Kind::kFrame, std::to_string(i)));
  EXPECT_FALSE(queue.take_dropped()) << "while it lags, another complete frame would be lost, too";
  for (size_t i = 0; i < OutgoingQueue::kMaxFrames; ++i)
    EXPECT_EQ(next(queue), std::to_string(100 - OutgoingQueue::kMaxFrames + i));
  EXPECT_TRUE(queue.take_dropped());
  EXPECT_FALSE(queue.take_dropped());
}

TEST(PageQueue, KeepsEachCamerasNewestPicture) {
  OutgoingQueue queue;
  for (const char* text : {"1", "2", "3"}) {
    queue.push(outgoing(Kind::kRightPicture, std::string("right ") + text));
    queue.push(outgoing(Kind::kLeftPicture, std::string("left ") + text));
  }
  EXPECT_EQ(next(queue), "left 3");
  EXPECT_EQ(next(queue), "right 3");
  EXPECT_FALSE(queue.take_dropped());
  queue.close();
  EXPECT_EQ(next(queue), "closed");
}

TEST(PageQueue, AnswersOvertakeFramesAndPictures) {
  OutgoingQueue queue;
  queue.push(outgoing(Kind::kPairPicture, "picture"));
  queue.push(outgoing(Kind::kFrame, "frame"));
  queue.push(outgoing(Kind::kAnswer, "answer"));
  EXPECT_EQ(next(queue), "answer");
  EXPECT_EQ(next(queue), "frame");
  EXPECT_EQ(next(queue), "picture");
}

TEST(PageQueue, ABrowserThatGetsNothingDoesNotFillTheMemory) {
  OutgoingQueue queue;
  const auto bytes = std::make_shared<const std::string>("text");
  for (int i = 0; i < 1000; ++i) {
    for (const Kind kind : {Kind::kAnswer, Kind::kFrame, Kind::kLeftPicture, Kind::kRightPicture, Kind::kPairPicture})
      queue.push({kind, bytes});
  }
  EXPECT_EQ(static_cast<size_t>(bytes.use_count()) - 1, OutgoingQueue::kMaxAnswers + OutgoingQueue::kMaxFrames + 3);
}

TEST(PageQueue, ClosingEndsTheWait) {
  OutgoingQueue queue;
  std::thread writer([&] { EXPECT_EQ(next(queue), "closed"); });
  queue.close();
  writer.join();
}

}  // namespace
}  // namespace multireach
