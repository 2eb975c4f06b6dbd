#include "studies/throws/throws.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/test_arms.hpp"

namespace multireach {
namespace {

TEST(Throws, LeadToAPositionWithinReach) {
  const Chain chain = testing::hoap2();
  for (uint64_t k = 0; k < 100; ++k) {
    const Throw thrown = sample_throw(chain, 5, k);
    EXPECT_GE(thrown.flight_s, 0.5);
    EXPECT_LE((thrown.position(thrown.flight_s) - chain.fixed(0).translation()).norm(), chain.reach());
    EXPECT_GT((thrown.release - thrown.position(thrown.flight_s)).norm(), 1.4);
  }
}

// The same throws give the same counts; hardly anything is met by one whose eyes are off by a decimetre. A throw that
// is met though no hand should be in time shows a bound that is none: of 40 throws at a small arm none is.
TEST(Throws, AreMetWhereAHandCanBeInTime) {
  const Chain chain = testing::hoap2();
  const nlohmann::json exact = run_throws(chain, 40, 3, {.sigma_m = 0}),
                       again = run_throws(chain, 40, 3, {.sigma_m = 0}),
                       blind = run_throws(chain, 40, 3, {.sigma_m = 0.1});
  EXPECT_EQ(exact, again);
  EXPECT_EQ(exact["met"], exact["met_of_seen_in_time"]);
  EXPECT_LE(exact["seen_in_time"], exact["in_time"]);
  EXPECT_GT(exact["met"], 20) << "most";
  EXPECT_LT(blind["met"].get<int>(), exact["met"].get<int>() / 4);
}

}  // namespace
}  // namespace multireach
