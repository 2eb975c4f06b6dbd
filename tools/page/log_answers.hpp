#pragma once

#include <map>
#include <string>
#include <string_view>

#include "tools/page/page_answer.hpp"
#include "tools/page/shown_runs.hpp"

namespace multireach {

/// Answers the page's questions about recorded runs. Each question names all that it depends on, so that every browser
/// has a position of its own in the log. Times are microseconds since the first event of the recorded log; `run` is a
/// run's number in ShownRuns, and `event` counts the events of that run's log from 0.
///
///   /log/overview                          duration, channels, target's status over time
///   /log/state?run&event|at                the newest message of each channel up to an event or a time
///   /log/span?run&after&until&step         messages in a time, one for each sender every `step` at most
///   /log/step?run&event&by=1|-1[&channel]  the next or previous message
///   /log/picture?run&event|at&side[&width] an image as JPEG: side left, right or pair (vision's debug picture); at a
///                                          time, of the newest stereo pair
///
/// A run that was removed is answered by status 204, without content.
class LogAnswers {
 public:
  explicit LogAnswers(const ShownRuns& runs) : runs_(runs) {}
  /// `path` begins with /log/; `query` as in "run=0&at=5". Several threads may call it.
  PageAnswer answer(std::string_view path, std::string_view query) const;

 private:
  const ShownRuns& runs_;
};

}  // namespace multireach
