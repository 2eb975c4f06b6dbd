// Pairs from times alone: two clocks of the test's own making, nothing sleeps.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "camera/pairing/frame_pairing.hpp"
#include "camera/pairing/skew_statistics.hpp"
#include "numeric/random.hpp"

namespace multireach {
namespace {

constexpr int64_t kPeriod = 33333;  // us

struct Camera {
  int64_t first = 0;
  double period = kPeriod;
  int64_t jitter = 0;   // us, uniform to both sides
  double missing = 0;   // ratio
  int64_t latency = 0;  // from capture to arrival
};

std::vector<int64_t> captures(const Camera& camera, int64_t until, uint64_t seed) {
  const CounterRandom random(seed);
  std::vector<int64_t> times;
  for (uint64_t k = 0;; ++k) {
    const double at = static_cast<double>(camera.first) + static_cast<double>(k) * camera.period;
    if (at > static_cast<double>(until)) return times;
    if (random.uniform(2 * k) < camera.missing) continue;
    times.push_back(
        static_cast<int64_t>(at + static_cast<double>(camera.jitter) * (2 * random.uniform(2 * k + 1) - 1)));
  }
}

struct Outcome {
  std::vector<int64_t> left{}, right{};
  std::vector<std::pair<int64_t, int64_t>> pairs{};
  int64_t unpaired = 0, waiting = 0;
};

/// Frames in the order in which they arrive.
Outcome run(const Camera& left, const Camera& right, int64_t until, uint64_t seed, int64_t max_skew = kPeriod / 2) {
  Outcome result{.left = captures(left, until, seed), .right = captures(right, until, seed + 1)};
  struct Arrival {
    int64_t at;
    Side side;
    int64_t utime;
  };
  std::vector<Arrival> arrivals;
  for (const int64_t t : result.left) arrivals.push_back({t + left.latency, Side::kLeft, t});
  for (const int64_t t : result.right) arrivals.push_back({t + right.latency, Side::kRight, t});
  std::ranges::stable_sort(arrivals, {}, &Arrival::at);
  FramePairing pairing(kPeriod, max_skew);
  for (const Arrival& arrival : arrivals) {
    for (const auto& pair : pairing.add(arrival.side, Frame{.utime = arrival.utime}))
      result.pairs.emplace_back(pair.left.utime, pair.right.utime);
  }
  result.unpaired = pairing.unpaired();
  result.waiting = static_cast<int64_t>(pairing.waiting(Side::kLeft) + pairing.waiting(Side::kRight));
  return result;
}

/// What must hold of any run. Returns what does not, so that it can be tested itself.
std::string fault_of(const Outcome& run, int64_t max_skew) {
  for (size_t i = 0; i < run.pairs.size(); ++i) {
    const auto [left, right] = run.pairs[i];
    if (std::abs(right - left) > max_skew) return "too far apart";
    if (!std::ranges::binary_search(run.left, left) || !std::ranges::binary_search(run.right, right)) return "made up";
    if (i > 0 && (left <= run.pairs[i - 1].first || right <= run.pairs[i - 1].second)) return "not in order";
  }
  const auto frames = static_cast<int64_t>(run.left.size() + run.right.size());
  const auto paired = 2 * static_cast<int64_t>(run.pairs.size());
  if (frames != paired + run.unpaired + run.waiting) return "not all accounted for";
  return "";
}

/// Pairs that nobody would dispute: each the other's nearest, by far.
int64_t plain_pairs(const Outcome& run, int64_t max_skew, int64_t margin) {
  const auto nearest = [](const std::vector<int64_t>& times, int64_t t) {
    std::vector<int64_t> apart;
    apart.reserve(times.size());
    for (const int64_t other : times) apart.push_back(std::abs(other - t));
    std::ranges::sort(apart);
    return apart;
  };
  int64_t plain = 0;
  for (const int64_t left : run.left) {
    const auto apart = nearest(run.right, left);
    if (apart[0] > max_skew || apart[1] < apart[0] + margin) continue;
    ++plain;
  }
  return plain;
}

TEST(FramePairing, PairsCamerasOfOnePhase) {
  const Outcome r = run({}, {}, 10000000, 1);
  EXPECT_EQ(fault_of(r, kPeriod / 2), "");
  EXPECT_EQ(r.pairs.size(), r.left.size());
  EXPECT_EQ(r.unpaired, 0);
}

TEST(FramePairing, PairsWithTheNearestAtAnyPhaseAndLatency) {
  for (int64_t phase = -16000; phase <= 16000; phase += 1000) {
    for (const int64_t latency : {0, 5000, 20000, 60000}) {
      const Outcome r = run({.latency = latency}, {.first = 100000 + phase, .jitter = 300}, 5000000, 7);
      EXPECT_EQ(fault_of(r, kPeriod / 2), "") << phase;
      for (const auto& [left, right] : r.pairs)
        EXPECT_LE(std::abs(right - left - phase), 450) << phase << " with latency " << latency;
      EXPECT_GE(r.pairs.size() + 5, r.right.size()) << phase << " with latency " << latency;
    }
  }
}

TEST(FramePairing, FollowsDriftThroughAllPhases) {
  // One camera 0.5 % faster: it gains a whole frame every 6.7 s, and only one frame is lost each time.
  const Outcome r = run({}, {.period = kPeriod * 0.995}, 60000000, 3);
  EXPECT_EQ(fault_of(r, kPeriod / 2), "");
  EXPECT_GE(r.pairs.size() + 20, r.left.size());
  EXPECT_LE(r.unpaired, 30);
}

TEST(FramePairing, LosesOnlyThePartnersOfMissingFrames) {
  for (uint64_t seed = 10; seed < 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Outcome r = run({.jitter = 2000, .missing = 0.1, .latency = 3000},
                          {.first = 5000, .jitter = 2000, .missing = 0.1, .latency = 30000}, 20000000, seed);
    EXPECT_EQ(fault_of(r, kPeriod / 2), "");
    EXPECT_GE(static_cast<int64_t>(r.pairs.size()), plain_pairs(r, kPeriod / 2, 6000) - 1);
  }
}

TEST(FramePairing, TakesTheNearestOfAFasterCamera) {
  const Outcome r = run({}, {.first = 2000, .period = kPeriod / 2.0, .latency = 8000}, 10000000, 5);
  EXPECT_EQ(fault_of(r, kPeriod / 2), "");
  EXPECT_GE(r.pairs.size() + 2, r.left.size());
  // The period of the faster one has first to be learnt.
  for (size_t i = 5; i < r.pairs.size(); ++i) EXPECT_LE(std::abs(r.pairs[i].second - r.pairs[i].first), 2002);
}

TEST(FramePairing, KeepsToTheConfiguredSkew) {
  const Outcome never = run({}, {.first = 3000}, 5000000, 5, 2000);
  EXPECT_EQ(fault_of(never, 2000), "");
  EXPECT_TRUE(never.pairs.empty());
  EXPECT_GT(never.unpaired, 280);
  EXPECT_GT(run({}, {.first = 1999}, 5000000, 5, 2000).pairs.size(), 145U);
  EXPECT_EQ(run({}, {}, 5000000, 5, 0).pairs.size(), 151U);
}

TEST(FramePairing, OutlivesASideThatStops) {
  FramePairing pairing(kPeriod, kPeriod / 2);
  int64_t t = 0;
  size_t pairs = 0;
  for (; t < 30 * kPeriod; t += kPeriod) {
    pairs += pairing.add(Side::kLeft, Frame{.utime = t}).size();
    pairs += pairing.add(Side::kRight, Frame{.utime = t + 100}).size();
  }
  EXPECT_EQ(pairs, 30U);
  for (; t < 10000 * kPeriod; t += kPeriod) {
    EXPECT_TRUE(pairing.add(Side::kRight, Frame{.utime = t}).empty());
    ASSERT_LE(pairing.waiting(Side::kRight), FramePairing::kMaxQueue);
  }
  pairing.reset(Side::kLeft);
  for (int i = 0; i < 10; ++i, t += kPeriod) {
    pairs += pairing.add(Side::kRight, Frame{.utime = t}).size();
    pairs += pairing.add(Side::kLeft, Frame{.utime = t + 100}).size();
  }
  EXPECT_EQ(pairs, 40U) << "from the first frame on";
  EXPECT_EQ(pairing.unpaired(), 10000 - 30);
}

TEST(FramePairing, DoesNotWaitForAFrameThatIsOverdue) {
  FramePairing pairing(kPeriod, 2 * kPeriod);
  EXPECT_TRUE(pairing.add(Side::kLeft, Frame{.utime = 0}).empty());
  EXPECT_TRUE(pairing.add(Side::kRight, Frame{.utime = 20000}).empty()) << "33 is nearer to 20 than 0";
  EXPECT_TRUE(pairing.add(Side::kRight, Frame{.utime = 20000 + kPeriod}).empty());
  EXPECT_EQ(pairing.add(Side::kRight, Frame{.utime = 20000 + 2 * kPeriod}).size(), 1U);
}

TEST(FramePairing, DropsTimesThatGoBack) {
  FramePairing pairing(kPeriod, kPeriod / 2);
  pairing.add(Side::kLeft, Frame{.utime = 1000000});
  EXPECT_TRUE(pairing.add(Side::kLeft, Frame{.utime = 1000000}).empty());
  EXPECT_TRUE(pairing.add(Side::kLeft, Frame{.utime = 5}).empty());
  EXPECT_EQ(pairing.unpaired(), 2);
  EXPECT_EQ(pairing.add(Side::kRight, Frame{.utime = 1000000}).size(), 1U);
}

TEST(FramePairing, CarriesTheImages) {
  FramePairing pairing(kPeriod, kPeriod / 2);
  pairing.add(Side::kRight, Frame{.utime = 10, .data = {2}});
  const auto pairs = pairing.add(Side::kLeft, Frame{.utime = 0, .data = {1}});
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].left.data, std::vector<uint8_t>{1});
  EXPECT_EQ(pairs[0].right.data, std::vector<uint8_t>{2});
}

TEST(FramePairing, RefusesWhatIsNoPeriod) {
  EXPECT_THROW(FramePairing(0, 1), std::invalid_argument);
  EXPECT_THROW(FramePairing(1, -1), std::invalid_argument);
}

TEST(FramePairing, TheCheckRejects) {
  const Outcome good = run({}, {}, 1000000, 1);
  Outcome bad = good;
  bad.pairs[3].second += 20000;
  EXPECT_EQ(fault_of(bad, kPeriod / 2), "too far apart");
  bad = good;
  ++bad.pairs[3].second;
  EXPECT_EQ(fault_of(bad, kPeriod / 2), "made up");
  bad = good;
  std::swap(bad.pairs[3], bad.pairs[4]);
  EXPECT_EQ(fault_of(bad, kPeriod / 2), "not in order");
  bad = good;
  bad.pairs.pop_back();
  EXPECT_EQ(fault_of(bad, kPeriod / 2), "not all accounted for");
}

TEST(SkewStatistics, AreOfTheLastSecond) {
  SkewStatistics skew;
  EXPECT_FALSE(skew.last_second());
  for (int64_t t = 0; t < 3000000; t += kPeriod) skew.add(t, t < 1000000 ? 9000 : t < 2500000 ? -1200 : 1500);
  const auto summary = skew.last_second();
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->pairs, 31);
  EXPECT_EQ(summary->max_us, 1500);
  EXPECT_EQ(summary->median_us, -1200);
  skew.add(10000000, -7000);
  EXPECT_EQ(skew.last_second()->median_us, -7000);
  EXPECT_EQ(skew.last_second()->max_us, 7000);
}

}  // namespace
}  // namespace multireach
