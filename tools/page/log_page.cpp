#include "tools/page/log_page.hpp"

#include <nlohmann/json.hpp>

#include "runtime/files.hpp"
#include "runtime/json_text.hpp"

namespace multireach {
namespace {

using json = nlohmann::ordered_json;

}  // namespace

void LogPage::answer(const std::string& word, bool accepted, const std::string& text) {
  browsers_.send(Outgoing::Kind::kAnswer, json_text({{"answer", word}, {"accepted", accepted}, {"text", text}}));
}

void LogPage::handle(const std::string& text) {
  const json request = json::parse(text, nullptr, false);
  if (!request.is_object()) return answer("page", false, "a request of the page is no JSON object");
  try {
    if (request.contains("recompute")) {
      const json& asked = request["recompute"];
      runs_.recompute(asked.at("set").get<std::vector<std::string>>(), asked.at("robot_model").get<std::string>());
      answer("what if", true, "the session is computed again");
    } else if (request.contains("remove_run")) {
      runs_.remove(request["remove_run"].get<int64_t>());
    } else if (request.contains("request")) {
      answer("page", false, "a log is shown: there is no robot to command");
    }
  } catch (const InputError& error) {
    answer("what if", false, error.what());
  } catch (const std::invalid_argument& error) {  // of a stage
    answer("what if", false, error.what());
  } catch (const json::exception&) {
    answer("what if", false, "expected {\"recompute\": {\"set\": [\"KEY=VALUE\"], \"robot_model\": \"ideal\"}}");
  }
}

void LogPage::step() {
  for (const std::string& text : browsers_.take_requests()) handle(text);
  const bool all = browsers_.take_needs_all();
  const int64_t version = runs_.version();
  if (!all && version == sent_version_) return;
  sent_version_ = version;
  browsers_.send(Outgoing::Kind::kAnswer, json_text(runs_.json()));
}

}  // namespace multireach
