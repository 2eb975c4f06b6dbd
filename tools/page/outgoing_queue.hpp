#pragma once

#include <array>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace multireach {

/// What is sent to a browser. The bytes are shared by all browsers.
struct Outgoing {
  enum class Kind {
    kAnswer,        ///< text: to a request
    kFrame,         ///< text: messages that arrived since the frame before
    kLeftPicture,   ///< a JPEG, of which only the newest matters
    kRightPicture,  ///< as kLeftPicture
    kPairPicture,   ///< as kLeftPicture: both images side by side
  };
  Kind kind = Kind::kFrame;
  std::shared_ptr<const std::string> bytes;
};

/// What waits for one browser, between the node, which never waits, and the thread that writes to the browser. Of
/// pictures only the newest waits, of frames and answers the newest few: a browser that lags loses old ones.
class OutgoingQueue {
 public:
  static constexpr size_t kMaxFrames = 4;
  static constexpr size_t kMaxAnswers = 32;

  void push(Outgoing outgoing);
  /// The next one to write, answers first; waits for it. Nothing once closed.
  std::optional<Outgoing> pop();
  void close();
  /// Whether frames were dropped since the last call, so that the browser needs all messages again.
  bool take_dropped();

 private:
  static constexpr size_t kPictures = 3;

  bool empty() const;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Outgoing> answers_, frames_;
  std::array<std::optional<Outgoing>, kPictures> pictures_;
  bool closed_ = false, dropped_ = false;
};

}  // namespace multireach
