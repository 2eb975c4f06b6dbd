#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "runtime/files.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/page/listening_socket.hpp"
#include "tools/page/page_server.hpp"

namespace multireach {
namespace {

/// A TCP connection to this computer.
class Connection {
 public:
  explicit Connection(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    const sockaddr_in name{.sin_family = AF_INET,
                           .sin_port = htons(static_cast<uint16_t>(port)),
                           .sin_addr = {htonl(INADDR_LOOPBACK)},
                           .sin_zero = {}};
    EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&name), sizeof name), 0);
  }
  ~Connection() { ::close(socket_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void send(const std::string& text) const {
    EXPECT_EQ(::send(socket_, text.data(), text.size(), 0), ssize_t(text.size()));
  }
  /// What arrives until `part` is in it, or until the connection ends.
  std::string read_until(const std::string& part) {
    std::string bytes(4096, '\0');
    while (text_.find(part) == std::string::npos) {
      const ssize_t got = recv(socket_, bytes.data(), bytes.size(), 0);
      if (got <= 0) break;
      text_.append(bytes, 0, static_cast<size_t>(got));
    }
    return text_;
  }

 private:
  int socket_;
  std::string text_;
};

class PageServing : public ::testing::Test {
 protected:
  void SetUp() override { std::ofstream(folder_ / "index.html") << "<p>the page</p>"; }

  PageServer::Options options() const {
    return {.folder = folder_.path(), .access = {.token = "secret"}, .greeting = "hello"};
  }
  static std::string get(int port, const std::string& host) {
    Connection connection(port);
    connection.send("GET / HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n");
    return connection.read_until("\xff never");
  }
  static std::string upgrade(const std::string& origin, const std::string& token) {
    return "GET /messages?token=" + token + " HTTP/1.1\r\nHost: 127.0.0.1\r\nOrigin: " + origin +
           "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: "
           "AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n";
  }
  /// A text of less than 126 bytes as a browser sends it (RFC 6455), with a mask of zeros.
  static std::string frame(const std::string& text) {
    return std::string("\x81") + static_cast<char>(0x80 | text.size()) + std::string(4, '\0') + text;
  }

  const testing::TemporaryFolder folder_;
};

TEST_F(PageServing, ServesThePageToItsOwnNamesOnly) {
  const PageServer server(options());
  const std::string page = get(server.port(), "127.0.0.1");
  EXPECT_NE(page.find("200 OK"), std::string::npos) << page;
  EXPECT_NE(page.find("<p>the page</p>"), std::string::npos) << page;
  EXPECT_NE(page.find("Content-Security-Policy: default-src 'none'"), std::string::npos) << page;
  const std::string refused = get(server.port(), "evil.example");
  EXPECT_NE(refused.find("403"), std::string::npos) << refused;
  EXPECT_EQ(refused.find("the page</p>"), std::string::npos) << refused;
}

TEST_F(PageServing, MessagesGoToBrowsersWithTheTokenOnly) {
  PageServer server(options());
  for (const auto& [origin, token] : {std::pair("http://127.0.0.1", "wrong"), {"http://evil.example", "secret"}}) {
    Connection connection(server.port());
    connection.send(upgrade(origin, token));
    EXPECT_EQ(connection.read_until("hello").find("101"), std::string::npos) << origin << ' ' << token;
    EXPECT_EQ(server.count(), 0);
  }
  Connection connection(server.port());
  connection.send(upgrade("http://127.0.0.1", "secret"));
  EXPECT_NE(connection.read_until("hello").find("101 Switching Protocols"), std::string::npos);
  connection.send(frame("first") + frame("second"));
  std::vector<std::string> requests;
  while (requests.size() < 2) {
    for (std::string& request : server.take_requests()) requests.push_back(std::move(request));
    std::this_thread::yield();
  }
  EXPECT_EQ(requests, (std::vector<std::string>{"first", "second"}));
  EXPECT_EQ(server.count(), 1);
  EXPECT_TRUE(server.take_needs_all());
  EXPECT_FALSE(server.take_needs_all());
  server.send(Outgoing::Kind::kFrame, "a frame");
  EXPECT_NE(connection.read_until("a frame").find("a frame"), std::string::npos);
  server.send(Outgoing::Kind::kLeftPicture, "JPEG");
  EXPECT_NE(connection.read_until("\x02JPEG").find("\x82\x05\x02JPEG"), std::string::npos);
}

TEST_F(PageServing, ABrowserThatReadsNothingDelaysNobodyAndEndsWithTheServer) {
  PageServer server(options());
  const Connection deaf(server.port());
  deaf.send(upgrade("http://127.0.0.1", "secret"));
  Connection other(server.port());
  other.send(upgrade("http://127.0.0.1", "secret"));
  other.read_until("hello");
  while (server.count() < 2) std::this_thread::yield();
  // More than the sockets' buffers hold; this thread, which is the node's, would wait here for ever if it wrote itself.
  const std::string large(1000000, 'x');
  for (int i = 0; i < 50; ++i) server.send(Outgoing::Kind::kFrame, large);
  server.send(Outgoing::Kind::kAnswer, "the answer");
  EXPECT_NE(other.read_until("the answer").find("the answer"), std::string::npos);
}

// A browser takes what follows a cut message as the rest of it, then ends with "Invalid frame header".
TEST_F(PageServing, ABrowserThatTakesOnlyAPartOfAMessageGetsNoOtherOne) {
  PageServer server(options());
  Connection slow(server.port());
  slow.send(upgrade("http://127.0.0.1", "secret"));
  while (server.count() < 1) std::this_thread::yield();
  const std::string large(1000000, 'x');
  for (int i = 0; i < 50; ++i) {
    server.send(Outgoing::Kind::kFrame, large);
    std::this_thread::yield();
  }
  while (server.count() > 0) std::this_thread::yield();
  const std::string text = slow.read_until("never");
  size_t at = text.find("\r\n\r\n") + 4, frames = 0;
  for (; at < text.size(); ++frames) {
    ASSERT_EQ(text[at], '\x81') << frames;  // a whole message of text
    ASSERT_LT(at + 10, text.size());
    const int length = text[at + 1];
    at += length < 126 ? 2 + static_cast<size_t>(length) : 10 + large.size();
  }
  EXPECT_GE(frames, 2u) << "the greeting, and one that is cut";
}

TEST_F(PageServing, ListensAtASocketThatAnotherProgramOpened) {
  const int socket = open_listening_socket("127.0.0.1", 0);
  const int port = listening_port(socket);
  auto given = options();
  given.socket = socket;
  {
    const PageServer server(given);
    EXPECT_EQ(server.port(), port);
    EXPECT_NE(get(port, "127.0.0.1").find("the page"), std::string::npos);
  }
  const PageServer again(given);  // as after a restart of the process: the socket is still open
  EXPECT_NE(get(port, "127.0.0.1").find("the page"), std::string::npos);
  ::close(socket);
}

TEST_F(PageServing, SaysWhatIsWrongWithTheSocketOrThePort) {
  EXPECT_THROW(listening_port(0), InputError);
  EXPECT_THROW(open_listening_socket("localhost", 0), InputError);
  const int socket = open_listening_socket("127.0.0.1", 0);
  EXPECT_THROW(open_listening_socket("127.0.0.1", listening_port(socket)), InputError);
  auto taken = options();
  taken.port = listening_port(socket);
  EXPECT_THROW(PageServer{taken}, InputError);
  ::close(socket);
}

}  // namespace
}  // namespace multireach
