// Sockets and pseudo-terminals of the drivers, with the kernel's own.
#include "robot_bridge/drivers/node/transport.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <utility>

#include "runtime/files.hpp"
#include "tests/temporary_folder.hpp"

namespace multireach::drivers {
namespace {

/// A robot's TCP server on a free port of this machine.
class Server {
 public:
  Server() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(listener_, 1), 0);
    socklen_t size = sizeof address;
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port = ntohs(address.sin_port);
  }
  ~Server() {
    hang_up();
    ::close(listener_);
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  void accept() {
    const int accepted = ::accept(listener_, nullptr, nullptr);
    if (accepted < 0) return;
    if (connection_ >= 0) ::close(connection_);
    connection_ = accepted;
  }
  /// As many of these bytes as the connection takes at once.
  ssize_t send(const std::vector<uint8_t>& bytes) const {
    return ::send(connection_, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  }
  /// Closes with a reset, as a robot that is switched off does.
  void hang_up() {
    if (connection_ < 0) return;
    const linger at_once{1, 0};
    ::setsockopt(connection_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    ::close(std::exchange(connection_, -1));
  }

  int port = 0;

 private:
  int listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
  int connection_ = -1;
};

Link tcp(int port) {
  return {.kind = Link::Kind::kTcp, .address = "127.0.0.1", .number = port};
}

/// Calls until it is true, or fails after ten seconds.
template <class Condition>
void await(const Condition& condition) {
  for (int k = 0; k < 10000; ++k) {
    if (condition()) return;
    ::poll(nullptr, 0, 1);
  }
  FAIL() << "nothing happened for 10 s";
}

// With the signal's default action, which the programs have, the process would end.
TEST(TcpClient, ARobotThatClosesItsConnectionIsNoSignal) {
  ASSERT_EQ(std::signal(SIGPIPE, SIG_DFL), SIG_DFL);
  Server server;
  const Transports transports = client_transports({tcp(server.port)});
  int64_t now = 0;
  await([&] { return transports[0]->open(now += 1000); });
  server.accept();
  server.hang_up();
  const std::vector<uint8_t> bytes(100, 7);
  await([&] { return !transports[0]->send(bytes); });
  EXPECT_FALSE(transports[0]->send(bytes));
  transports[0]->close();
  await([&] { return transports[0]->open(now += 1000); });
}

// A robot that sends without an end must not keep the driver from its period.
TEST(TcpClient, AFloodIsReadInParts) {
  Server server;
  const Transports transports = client_transports({tcp(server.port)});
  int64_t now = 0;
  await([&] { return transports[0]->open(now += 1000); });
  server.accept();
  ssize_t sent = 0;
  await([&] { return (sent += std::max<ssize_t>(0, server.send(std::vector<uint8_t>(10000, 7)))) >= 150000; });
  size_t received = 0, most = 0;
  await([&] {
    std::vector<uint8_t> bytes;
    EXPECT_TRUE(transports[0]->receive(bytes));
    most = std::max(most, bytes.size());
    return (received += bytes.size()) >= static_cast<size_t>(sent);
  });
  EXPECT_LE(most, 70000U);
}

// A listener whose queue is full drops what comes: the connection is neither accepted nor refused.
TEST(TcpClient, AConnectionThatIsNeverAcceptedIsTriedAgain) {
  Server full;
  std::vector<Transports> others;
  for (int k = 0; k < 4; ++k) {
    others.push_back(client_transports({tcp(full.port)}));
    others.back()[0]->open(0);
  }
  const Transports transports = client_transports({tcp(full.port)});
  EXPECT_FALSE(transports[0]->open(0));
  EXPECT_FALSE(transports[0]->open(1000000));
  EXPECT_FALSE(transports[0]->open(4000000)) << "given up after three seconds, by the time of the arguments";
  await([&] {
    full.accept();
    return transports[0]->open(5000000);
  });
}

class SerialEmulator : public ::testing::Test {
 protected:
  std::string sentence() const {
    try {
      (void)emulator_transports({link});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  const testing::TemporaryFolder folder;
  const Link link{.kind = Link::Kind::kSerial, .address = folder / "servos", .number = 1000000};
};

TEST_F(SerialEmulator, ReplacesNoFileAndNoDeviceThatExists) {
  std::ofstream(link.address) << "mine";
  EXPECT_NE(sentence().find("exists"), std::string::npos) << sentence();
  EXPECT_EQ(std::filesystem::file_size(link.address), 4U);
  std::filesystem::remove(link.address);
  std::filesystem::create_symlink("/dev/null", link.address);
  EXPECT_NE(sentence().find("exists"), std::string::npos) << sentence();
  EXPECT_EQ(std::filesystem::read_symlink(link.address), "/dev/null");
}

TEST_F(SerialEmulator, ReplacesTheLinkOfAnEmulatorThatWasKilled) {
  std::filesystem::create_symlink("/dev/pts/nobody", link.address);
  const Transports emulator = emulator_transports({link});
  EXPECT_TRUE(std::filesystem::is_character_file(link.address));
  EXPECT_NE(sentence().find("exists"), std::string::npos) << "a second one beside the first: " << sentence();
  const Transports driver = client_transports({link});
  ASSERT_TRUE(driver[0]->open(0));
  ASSERT_TRUE(driver[0]->send(std::vector<uint8_t>{1, 2, 3}));
  std::vector<uint8_t> received;
  await([&] { return emulator[0]->receive(received) && received.size() == 3; });
}

TEST_F(SerialEmulator, LeavesWhatAnotherPutInItsPlace) {
  {
    const Transports emulator = emulator_transports({link});
    std::filesystem::remove(link.address);
    std::ofstream(link.address) << "mine";
  }
  EXPECT_TRUE(std::filesystem::exists(link.address));
}

// A process with the right to do so would write its packets into any file.
TEST_F(SerialEmulator, NothingButASerialPortIsWritten) {
  const Transports early = client_transports({link});  // it is plugged in later
  EXPECT_FALSE(early[0]->open(0));
  std::ofstream(link.address) << "mine";
  EXPECT_FALSE(early[0]->open(10000000));
  EXPECT_EQ(std::filesystem::file_size(link.address), 4U);
  EXPECT_THROW((void)client_transports({link}), InputError);
  EXPECT_THROW((void)client_transports({{.kind = Link::Kind::kSerial, .address = folder.path(), .number = 1000000}}),
               InputError);
  const Transports null = client_transports({{.kind = Link::Kind::kSerial, .address = "/dev/null", .number = 1000000}});
  EXPECT_FALSE(null[0]->open(0));
}

}  // namespace
}  // namespace multireach::drivers
