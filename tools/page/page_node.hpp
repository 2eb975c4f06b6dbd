#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>

#include "imaging/image_codec.hpp"
#include "runtime/node.hpp"
#include "tools/page/browsers.hpp"
#include "tools/page/course.hpp"
#include "tools/page/drake_feed.hpp"
#include "tools/page/foxglove_feed.hpp"
#include "tools/page/touch.hpp"
#include "tools/robot/bridge_asker.hpp"

namespace multireach {

/// Sends browsers the newest message of each channel as JSON, 25 times a second, and newest pictures, 10 times a
/// second; sends their requests to the bridge. While no browser shows the page, it only counts messages.
class PageNode : public Node {
 public:
  struct Start {
    int64_t utime = 0;          ///< time of the first tick, microseconds
    int64_t first_request = 1;  ///< see BridgeAsker
    int64_t run = 1;            ///< see Touch
  };
  PageNode(Browsers& browsers, const Start& start);

  /// Also sends messages to Foxglove's clients.
  void feed_foxglove(FoxgloveHub& hub, const RobotConfig& robot, const StereoRig* rig);
  /// Also sends messages to Drake's viewer.
  void feed_drake(const RobotConfig& robot) { drake_.emplace(robot); }
  /// Offers the set-up course, whose files are in `folder`. Throws InputError.
  void offer_course(const RobotConfig& robot, const std::string& folder, bool practice);

  std::string name() const override { return "page"; }
  std::vector<std::string_view> inputs() const override;
  Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  std::optional<int64_t> next_tick() const override { return next_tick_us_; }
  int64_t tick_period_us() const override { return kTickUs; }
  LateTicks late_ticks() const override { return LateTicks::kSkip; }  // only what is newest is shown
  void skip_ticks(int64_t ticks) override { next_tick_us_ += ticks * kTickUs; }
  void tick(Outbox& out) override;
  std::string state() const override;

  static constexpr int64_t kTickUs = 20000;
  static constexpr int kTicksPerFrame = 2;
  static constexpr int64_t kPicturePeriodUs = 100000;
  static constexpr int kTicksPerCourse = 6;  ///< at most so often the course's state is sent
  static constexpr int64_t kSecond = 1000000;
  static constexpr int64_t kVisionLate = 100000;    ///< us behind the images: three pairs at 30 Hz
  static constexpr int64_t kVisionPause = 5000000;  ///< us in which a vision that is late is not asked to draw

 private:
  struct Newest {
    std::string_view channel;
    std::vector<uint8_t> bytes;
    bool sent = false;
  };

  void keep(std::string_view channel, const std::string& name, std::span<const uint8_t> bytes);
  void receive_stereo(std::span<const uint8_t> bytes);
  void receive_debug_picture(std::span<const uint8_t> bytes);
  void handle_requests(Outbox& out);
  void handle_request(const nlohmann::json& request, Outbox& out);
  /// `client`: the one of several browsers that asked; "" for all.
  void answer(const std::string& word, bool accepted, const std::string& text, const std::string& client = "");
  void ask_bridge(bool each_second, Outbox& out);
  void send_frame();
  void refuse(const std::string& why);
  bool watched() const { return browsers_.count() > 0; }

  Browsers& browsers_;
  int64_t next_tick_us_;
  int64_t ticks_ = 0, second_us_ = INT64_MIN;       // ticks computed; the last that began a second
  std::map<std::string, Newest> newest_;            // by channel, and where it has several senders by their names
  std::map<std::string_view, int64_t> count_;       // messages in this second
  std::map<std::string_view, int64_t> last_count_;  // in the one before
  BridgeAsker asker_;
  int64_t run_;
  Touch touch_;
  std::optional<Course> course_;
  std::string course_sent_;
  std::optional<int64_t> bridge_heard_us_, debug_picture_us_, picture_us_;
  bool contours_ = false;                 // whether a browser wants vision to draw what it sees
  std::optional<int64_t> images_utime_;   // of the newest images
  int64_t contours_from_us_ = INT64_MIN;  // vision is not asked before
  ImageCodec codec_;
  std::optional<FoxgloveFeed> foxglove_;
  std::optional<DrakeFeed> drake_;
};

}  // namespace multireach
