#include "studies/throws/throws.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/test_arms.hpp"

namespace multireach {
namespace {

TEST(Throws, LeadToAPlaceWithinReach) {
  const Chain chain = testing::hoap2();
  for (uint64_t k = 0; k < 100; ++k) {
    const Throw thrown = sample_throw(chain, 5, k);
    EXPECT_GE(thrown.flight_s, 0.5);
    EXPECT_LE((thrown.position(thrown.flight_s) - chain.fixed(0).translation()).norm(), chain.reach());
    EXPECT_GT((thrown.release - thrown.position(thrown.flight_s)).norm(), 1.4);
  }
}

// What is met was in time; with exact observations a small arm meets nearly what any hand could.
TEST(Throws, AreMetWhereAHandCanBeInTime) {
  const Chain chain = testing::hoap2();
  const nlohmann::json exact = run_throws(chain, 40, 3, {.sigma_m = 0}),
                       again = run_throws(chain, 40, 3, {.sigma_m = 0}),
                       blind = run_throws(chain, 40, 3, {.sigma_m = 0.1});
  EXPECT_EQ(exact, again);
  EXPECT_LE(exact["met"], exact["in_time"]);
  EXPECT_GE(exact["met"].get<double>(), 0.9 * exact["seen_in_time"].get<double>());
  EXPECT_LT(blind["met"], exact["met"]);
}

}  // namespace
}  // namespace multireach
