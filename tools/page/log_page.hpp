#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/page/browsers.hpp"
#include "tools/page/shown_runs.hpp"

namespace multireach {

/// What browsers ask of a page that shows a log, beyond reading: runs to compute or to forget. Tells them how far these
/// are.
class LogPage {
 public:
  LogPage(Browsers& browsers, ShownRuns& runs) : browsers_(browsers), runs_(runs) {}
  /// To be called some times a second.
  void step();

 private:
  void handle(const std::string& text);
  void answer(const std::string& word, bool accepted, const std::string& text);

  Browsers& browsers_;
  ShownRuns& runs_;
  int64_t sent_version_ = -1;
};

}  // namespace multireach
