// multireach-bench-key: time to sign and to check a message, by its size. Run it with --benchmark_min_time=0.5.
#include <benchmark/benchmark.h>

#include "runtime/tagged_message.hpp"

namespace multireach {
namespace {

constexpr int64_t kNow = 1'800'000'000'000'000;

void sign(benchmark::State& state) {
  MessageSigner signer(random_message_key(), 1);
  const std::vector<uint8_t> payload(static_cast<size_t>(state.range(0)), 7);
  std::vector<uint8_t> out;
  for (auto _ : state) {
    out.clear();
    signer.sign("JOINT_COMMAND", payload, kNow, out);
    benchmark::DoNotOptimize(out.data());
  }
}

/// Checks messages that were signed ahead; each is new and accepted.
void check(benchmark::State& state) {
  const MessageKey key = random_message_key();
  MessageSigner signer(key, 1);
  MessageVerifier verifier(key, 1000000);
  const std::vector<uint8_t> payload(static_cast<size_t>(state.range(0)), 7);
  std::vector<std::vector<uint8_t>> messages(1000);
  int64_t refused = 0;
  size_t next = messages.size();
  for (auto _ : state) {
    if (next == messages.size()) {
      state.PauseTiming();
      for (auto& message : messages) {
        message.clear();
        signer.sign("JOINT_COMMAND", payload, kNow, message);
      }
      next = 0;
      state.ResumeTiming();
    }
    refused += verifier.verify("JOINT_COMMAND", messages[next++], kNow).index() != 0;
  }
  if (refused > 0) state.SkipWithError("a message was refused");
}

BENCHMARK(sign)->Arg(100)->Arg(500)->Arg(40000)->Arg(1000000);
BENCHMARK(check)->Arg(100)->Arg(500)->Arg(40000);

}  // namespace
}  // namespace multireach

BENCHMARK_MAIN();
