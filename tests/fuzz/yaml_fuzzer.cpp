// Any text as a configuration: settings, or one sentence.
#include "runtime/config.hpp"
#include "runtime/rig_config.hpp"
#include "runtime/robot_config.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace multireach;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto tried = [](const auto& read) {
    try {
      read();
    } catch (const InputError&) {
    }
  };
  tried([&] {
    const Config file = Config::parse("fuzzed.yaml", text);
    tried([&] { load_rig(file.section("cameras")); });
    for (const char* key : {"robot", "controller", "tracker", "targets"}) {
      tried([&] { file.number(key, -1, 1); });
      tried([&] { file.integer(key, -1, 1); });
      tried([&] { file.flag(key); });
      tried([&] { file.text(key); });
      tried([&] { file.numbers(key, -1); });
      tried([&] { file.matrix(key, 2, 2); });
      tried([&] { file.texts(key); });
      tried([&] { file.named_numbers(key); });
      tried([&] { file.section(key).finish(); });
      tried([&] { file.sections(key); });
    }
    file.finish();
  });
  return 0;
}
