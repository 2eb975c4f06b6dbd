#pragma once

#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>

#include "tools/replay/run.hpp"
#include "vision/node/vision_node.hpp"

namespace multireach {

/// The vision node for a replay, with threads that decode the session's images ahead of the loop. Sends the same
/// messages as a VisionNode with the same images, because the decoding of an image does not depend on earlier images.
class PrefetchingVisionNode : public Node {
 public:
  explicit PrefetchingVisionNode(const ReplayOptions& options);
  ~PrefetchingVisionNode() override;

  std::string name() const override { return vision_.name(); }
  std::vector<std::string_view> inputs() const override { return vision_.inputs(); }
  Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  std::optional<int64_t> config_digest() const override { return vision_.config_digest(); }
  std::string state() const override { return vision_.state(); }

 private:
  void work();

  VisionNode vision_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  Session session_;
  int64_t started_ = 0, processed_ = 0;
  std::map<int64_t, StereoFrames> decoded_;
  std::exception_ptr failure_;
  bool stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace multireach
