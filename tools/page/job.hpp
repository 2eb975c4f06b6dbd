#pragma once

#include <chrono>
#include <functional>
#include <future>
#include <optional>

namespace multireach {

/// A computation that takes too long for a tick: runs in a thread of its own, one at a time. Its destructor waits.
template <class Result>
class Job {
 public:
  bool busy() const { return future_.valid(); }
  /// `work` must not share anything with the caller. What it throws, take() throws.
  void start(std::function<Result()> work) { future_ = std::async(std::launch::async, std::move(work)); }
  /// The result, once, when it is there.
  std::optional<Result> take() {
    if (!future_.valid() || future_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return std::nullopt;
    return future_.get();
  }

 private:
  std::future<Result> future_;
};

}  // namespace multireach
