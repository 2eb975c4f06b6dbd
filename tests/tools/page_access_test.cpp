#include <gtest/gtest.h>

#include <set>

#include "tools/page/access.hpp"

namespace multireach {
namespace {

const Access kAccess{.token = "0123456789abcdef", .host = "arm.lab"};

TEST(PageAccess, AnswersToAddressesAndItsOwnNames) {
  for (const char* host :
       {"127.0.0.1:8000", "127.0.0.1", "localhost:8000", "LOCALHOST", "192.168.0.7:80", "arm.lab:8000", "Arm.Lab"}) {
    EXPECT_TRUE(kAccess.allows_host(host)) << host;
  }
}

TEST(PageAccess, RefusesNamesThatSomebodyElseMadePointHere) {
  for (const char* host : {"", "evil.example", "evil.example:8000", "127.0.0.1.evil.example", "localhost.evil.example",
                           "127.0.0.1:", "127.0.0.1:80x", "127.1", "arm.lab.evil.example"}) {
    EXPECT_FALSE(kAccess.allows_host(host)) << host;
  }
  EXPECT_FALSE(Access{.token = "t"}.allows_host("arm.lab"));
}

TEST(PageAccess, MessagesNeedThePageOfThisServerAndTheToken) {
  const char* token = "token=0123456789abcdef";
  EXPECT_TRUE(kAccess.allows_messages("127.0.0.1:8000", "http://127.0.0.1:8000", token));
  EXPECT_FALSE(kAccess.allows_messages("evil.example", "http://evil.example", token));
  for (const char* origin : {"", "null", "http://evil.example", "http://127.0.0.1:8001", "https://127.0.0.1:8000",
                             "http://localhost:8000"}) {
    EXPECT_FALSE(kAccess.allows_messages("127.0.0.1:8000", origin, token)) << origin;
  }
  for (const char* query : {"", "token=", "token=0123456789abcdeg", "token=0123456789abcde", "token=0123456789abcdef0",
                            "x=1&token=0123456789abcdef"}) {
    EXPECT_FALSE(kAccess.allows_messages("127.0.0.1:8000", "http://127.0.0.1:8000", query)) << query;
  }
  EXPECT_FALSE(Access{}.allows_messages("127.0.0.1:8000", "http://127.0.0.1:8000", "token="));
}

TEST(PageAccess, TokensDiffer) {
  std::set<std::string> tokens;
  for (int i = 0; i < 20; ++i) tokens.insert(random_token());
  EXPECT_EQ(tokens.size(), 20U);
  EXPECT_EQ(tokens.begin()->size(), 32U);
}

}  // namespace
}  // namespace multireach
