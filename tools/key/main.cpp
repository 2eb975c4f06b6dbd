// multireach-key: makes the key with which programs sign their messages, and takes it to other computers.
#include <iostream>
#include <istream>
#include <iterator>

#include "runtime/key_file.hpp"
#include "runtime/message_gate.hpp"
#include "runtime/program.hpp"

namespace multireach {
namespace {

constexpr size_t kMaxInput = 1000;  // characters; a key has 90

std::string standard_input() {
  std::string text;
  for (char c = 0; text.size() < kMaxInput && std::cin.get(c);) text += c;
  return text;
}

int make(const std::string& path, bool shared) {
  write_key_file(path, shared ? key_in(standard_input(), "standard input") : random_message_key());
  std::cerr << "multireach-key: " << path << " is written; start all programs with --key " << path << "\n";
  return 0;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  using namespace multireach;
  Program program("multireach-key", "Makes the key with which programs sign their messages, and shares it.");
  CommandLine& cli = program.cli();
  cli.require_subcommand();
  program.add_config_reference([] { return key_policy_reference(); });
  std::string made, shared;
  bool from_input = false;
  CommandLine make_command = cli.subcommand("new", "write a new key to a file that only you can read");
  make_command.option("FILE", made, "the key file; an existing one is not replaced").required();
  make_command.flag("--shared", from_input, "not a new key, but the one that `share` printed, from standard input");
  CommandLine share_command =
      cli.subcommand("share", "print a key as one line of text, for `new --shared` on another computer");
  share_command.option("FILE", shared, "the key file").required();
  return program.run(argc, argv, [&] {
    if (make_command.given()) return make(made, from_input);
    std::cout << text_of(read_key_file(shared)) << "\n";
    return 0;
  });
}
