#include "tools/page/log_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <multireach/images_t.hpp>
#include <multireach/target_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/json_text.hpp"
#include "runtime/message.hpp"
#include "runtime/message_schema.hpp"
#include "tools/page/jpeg_image.hpp"

namespace multireach {
namespace {

using json = nlohmann::ordered_json;

constexpr int64_t kSecond = 1000000;  // us

/// What the page shows of messages.
constexpr std::array kShown{channel::kTarget,        channel::kTargetCandidates, channel::kObstacles,
                            channel::kJointSetpoint, channel::kControllerState,  channel::kJointCommand,
                            channel::kBridgeState,   channel::kRobotState,       channel::kNodeStatus};

bool is_shown(const LogIndex::Series& series) {
  return std::ranges::find(kShown, series.channel) != kShown.end();
}

struct Refused {
  std::string sentence;
};

/// "a=1&b=2" by names. Values are numbers and names of channels, so nothing is encoded.
class Query {
 public:
  explicit Query(std::string_view text) : text_(text) {}

  std::string_view word(std::string_view name) const {
    for (size_t begin = 0; begin < text_.size();) {
      const size_t end = std::min(text_.find('&', begin), text_.size());
      const std::string_view pair = text_.substr(begin, end - begin);
      if (pair.size() > name.size() && pair.starts_with(name) && pair[name.size()] == '=')
        return pair.substr(name.size() + 1);
      begin = end + 1;
    }
    return {};
  }
  bool has(std::string_view name) const { return !word(name).empty(); }
  /// A whole number, clipped to min and max. Throws Refused.
  int64_t number(std::string_view name, int64_t min, int64_t max) const {
    const std::string_view text = word(name);
    int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
      throw Refused{fmt::format("{} is '{}'; expected a whole number", name, text)};
    return std::clamp(value, min, max);
  }

 private:
  std::string_view text_;
};

/// A message as the page gets it; nothing when it is not well-formed.
std::optional<json> shown_message(const ShownRuns::View& run, int64_t i) {
  const LogEvent event = run.log->event(i);
  const MessageSchema* schema = MessageSchemas::project().of(event.data);
  auto message = schema ? json_of(*schema, event.data) : std::nullopt;
  if (!message) return std::nullopt;
  return json{{"channel", event.channel}, {"at", run.log->at_us(i) - run.offset_us}, {"message", std::move(*message)}};
}

/// The newest events with images.
json pictures_at(const LogIndex& log, int64_t event) {
  json pictures = json::object();
  for (const auto& [name, channel] :
       {std::pair("stereo", channel::kStereoImages), std::pair("pair", channel::kVisionDebug)}) {
    const LogIndex::Series* series = log.series_of(channel);
    const int64_t newest = series ? LogIndex::newest(*series, event) : -1;
    if (newest >= 0) pictures[name] = newest;
  }
  return pictures;
}

/// Messages of each channel in the second before.
json rates_at(const LogIndex& log, int64_t event) {
  json rates = json::object();
  const int64_t before = log.at_us(event) < kSecond ? -1 : log.event_before(log.at_us(event) - kSecond);
  for (const LogIndex::Series& series : log.series()) {
    const auto until = [&](int64_t last) {
      return std::ranges::upper_bound(series.events, last, {}, [](uint32_t e) { return int64_t{e}; });
    };
    const int64_t count = until(event) - until(before);
    if (count > 0) rates[series.channel] = rates.value(series.channel, int64_t{0}) + count;
  }
  return rates;
}

json position_at(const ShownRuns::View& run, int64_t event) {
  return {{"event", event},
          {"at", run.log->at_us(event) - run.offset_us},
          {"pictures", pictures_at(*run.log, event)},
          {"rates", rates_at(*run.log, event)}};
}

int64_t asked_event(const ShownRuns::View& run, const Query& query) {
  if (query.has("event")) return query.number("event", 0, run.log->size() - 1);
  return run.log->event_before(query.number("at", -kSecond * kSecond, kSecond * kSecond) + run.offset_us);
}

json state_answer(const ShownRuns::View& run, const Query& query) {
  const int64_t event = asked_event(run, query);
  json messages = json::array();
  for (const LogIndex::Series& series : run.log->series()) {
    const int64_t newest = is_shown(series) ? LogIndex::newest(series, event) : -1;
    if (newest < 0) continue;
    if (auto message = shown_message(run, newest)) messages.push_back(std::move(*message));
  }
  json answer = position_at(run, event);
  answer["messages"] = std::move(messages);
  return answer;
}

json span_answer(const ShownRuns::View& run, const Query& query) {
  constexpr int64_t kLongest = 3600 * kSecond;
  constexpr size_t kMostMessages = 20000;
  const LogIndex& log = *run.log;
  const int64_t until = query.number("until", -kLongest * 1000, kLongest * 1000) + run.offset_us;
  const int64_t after =
      std::max(query.number("after", -kLongest * 1000, kLongest * 1000) + run.offset_us, until - kLongest);
  const int64_t step = query.number("step", 1, kLongest);
  std::vector<int64_t> events;
  for (const LogIndex::Series& series : log.series()) {
    if (!is_shown(series)) continue;
    const auto time_of = [&](uint32_t event) { return log.at_us(event); };
    auto at = std::ranges::upper_bound(series.events, after, {}, time_of);
    const auto end = std::ranges::upper_bound(series.events, until, {}, time_of);
    while (at < end && events.size() < kMostMessages) {
      // The last one of each step.
      auto next = std::ranges::upper_bound(at, end, time_of(*at) + step - 1, {}, time_of);
      events.push_back(*std::prev(next));
      at = next;
    }
  }
  std::ranges::sort(events);
  json messages = json::array();
  for (const int64_t event : events) {
    if (auto message = shown_message(run, event)) messages.push_back(std::move(*message));
  }
  json answer = position_at(run, log.event_before(until));
  answer["messages"] = std::move(messages);
  return answer;
}

/// Messages with images name their size only.
json described(const LogEvent& event) {
  const MessageSchema* schema = MessageSchemas::project().of(event.data);
  if (!schema) return "a type that is not known";
  if (schema->name == "images_t") return fmt::format("images, {} bytes", event.data.size());
  const auto message = json_of(*schema, event.data);
  return message ? *message : json("damaged");
}

json step_answer(const ShownRuns::View& run, const Query& query) {
  const LogIndex& log = *run.log;
  const int64_t from = query.number("event", 0, log.size() - 1), by = query.number("by", -1, 1);
  int64_t found = std::clamp<int64_t>(from + by, 0, log.size() - 1);
  if (query.has("channel")) {
    int64_t nearest = -1;
    for (const LogIndex::Series& series : log.series()) {
      if (series.channel != query.word("channel")) continue;
      const auto after = std::ranges::upper_bound(series.events, from, {}, [](uint32_t e) { return int64_t{e}; });
      if (by > 0 && after != series.events.end() && (nearest < 0 || int64_t{*after} < nearest)) nearest = *after;
      if (by <= 0) nearest = std::max(nearest, LogIndex::newest(series, by < 0 ? from - 1 : from));
    }
    found = nearest < 0 ? from : nearest;
  }
  json answer = position_at(run, found);
  const LogEvent event = log.event(found);
  answer["channel"] = event.channel;
  answer["number"] = event.number;
  answer["message"] = described(event);
  return answer;
}

PageAnswer picture_answer(const ShownRuns::View& run, const Query& query) {
  constexpr int kLargestWidth = 640, kSmallestWidth = 16;
  int64_t asked = asked_event(run, query);
  if (!query.has("event")) {
    const LogIndex::Series* series = run.log->series_of(channel::kStereoImages);
    asked = series ? LogIndex::newest(*series, asked) : -1;
    if (asked < 0) return {.status = 204};
  }
  const LogEvent event = run.log->event(asked);
  const std::string_view side = query.word("side");
  const auto images = decode<images_t>(event.data);
  if (!images) return {.status = 204};
  const bool smaller = query.has("width");
  const auto width = static_cast<int>(smaller ? query.number("width", kSmallestWidth, kLargestWidth) : kLargestWidth);
  for (size_t i = 0; i < images->images.size(); ++i) {
    const int16_t wanted = side == "right" ? images_t::RIGHT : images_t::LEFT;
    if (images->image_types[i] != wanted && side != "pair") continue;
    ImageCodec codec;
    std::string jpeg = jpeg_of(images->images[i], codec, width, smaller);
    if (!jpeg.empty()) return {.type = "image/jpeg", .body = std::move(jpeg)};
  }
  return {.status = 204};
}

/// When the status of each target changed: [[at, status], ...].
json status_changes(const ShownRuns::View& run, const LogIndex::Series& series) {
  json changes = json::array();
  int before = -1;
  for (const uint32_t i : series.events) {
    const auto target = decode<target_t>(run.log->event(i).data);
    if (!target || target->status == before) continue;
    before = target->status;
    changes.push_back({run.log->at_us(i) - run.offset_us, before});
  }
  return changes;
}

json overview_answer(const ShownRuns::View& run) {
  json channels = json::object(), targets = json::object();
  for (const LogIndex::Series& series : run.log->series()) {
    channels[series.channel] = channels.value(series.channel, size_t{0}) + series.events.size();
    if (series.channel == channel::kTarget) targets[series.name] = status_changes(run, series);
  }
  return {{"duration_us", run.log->duration_us()},
          {"events", run.log->size()},
          {"channels", channels},
          {"targets", targets}};
}

}  // namespace

PageAnswer LogAnswers::answer(std::string_view path, std::string_view text) const {
  try {
    const Query query(text);
    const auto run = runs_.find(query.has("run") ? query.number("run", 0, INT64_MAX) : ShownRuns::kRecorded);
    if (!run) return {.status = 204};
    if (path == "/log/overview") return {.body = json_text(overview_answer(*run))};
    if (path == "/log/state") return {.body = json_text(state_answer(*run, query))};
    if (path == "/log/span") return {.body = json_text(span_answer(*run, query))};
    if (path == "/log/step") return {.body = json_text(step_answer(*run, query))};
    if (path == "/log/picture") return picture_answer(*run, query);
    throw Refused{fmt::format("'{}' is no question; expected overview, state, span, step or picture", path)};
  } catch (const Refused& refused) {
    return {.status = 400, .type = "text/plain", .body = refused.sentence};
  }
}

}  // namespace multireach
