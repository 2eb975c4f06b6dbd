#include "robot_bridge/drivers/node/transport.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

#include "runtime/files.hpp"

namespace multireach::drivers {
namespace {

constexpr int64_t kRetryPeriod = 500000;      // us
constexpr int64_t kConnectTimeout = 3000000;  // us; the kernel's own takes two minutes
constexpr size_t kMaxReceived = size_t{1} << 16;
constexpr size_t kMaxPending = size_t{1} << 16;  // bytes that the other side has not taken yet

/// A file descriptor that never blocks.
class DescriptorTransport : public Transport {
 public:
  ~DescriptorTransport() override { close_descriptor(); }

  bool receive(std::vector<uint8_t>& bytes) override {
    std::array<uint8_t, 4096> buffer;
    for (size_t received = 0; descriptor_ >= 0;) {
      if (received >= kMaxReceived) return true;  // the rest in the next period: a flood must not keep this one
      const ssize_t count = ::read(descriptor_, buffer.data(), buffer.size());
      if (count < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
      if (count == 0) return false;
      bytes.insert(bytes.end(), buffer.begin(), buffer.begin() + count);
      received += static_cast<size_t>(count);
    }
    return false;
  }

  bool send(std::span<const uint8_t> bytes) override {
    pending_.insert(pending_.end(), bytes.begin(), bytes.end());
    while (!pending_.empty()) {
      const ssize_t count = write_some();
      if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) break;
      if (count <= 0) return false;
      pending_.erase(pending_.begin(), pending_.begin() + count);
    }
    return pending_.size() < kMaxPending;
  }

  void close() override { close_descriptor(); }

 protected:
  void close_descriptor() {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = -1;
    pending_.clear();
  }

  int descriptor_ = -1;
  std::vector<uint8_t> pending_;

 private:
  /// Without the signal SIGPIPE, which would end the process, when the other side has closed a socket.
  ssize_t write_some() const {
    const ssize_t count = ::send(descriptor_, pending_.data(), pending_.size(), MSG_NOSIGNAL);
    return count < 0 && errno == ENOTSOCK ? ::write(descriptor_, pending_.data(), pending_.size()) : count;
  }
};

void set_no_delay(int socket) {
  const int on = 1;
  ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

class TcpClient : public DescriptorTransport {
 public:
  TcpClient(const std::string& host, int port) {
    addrinfo hints{};
    hints.ai_family = AF_INET;
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    if (::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found) != 0 || !found)
      throw InputError("driver.host: '" + host.substr(0, 100) + "' has no IPv4 address");
    std::memcpy(&address_, found->ai_addr, sizeof address_);
    ::freeaddrinfo(found);
  }

  bool open(int64_t now_us) override {
    if (connected_ && descriptor_ >= 0) return true;
    connected_ = false;
    if (descriptor_ >= 0) {
      pollfd state{descriptor_, POLLOUT, 0};
      if (::poll(&state, 1, 0) == 0) {
        if (now_us - next_attempt_us_ > kConnectTimeout - kRetryPeriod) close_descriptor();
        return false;
      }
      int error = 0;
      socklen_t size = sizeof error;
      ::getsockopt(descriptor_, SOL_SOCKET, SO_ERROR, &error, &size);
      if (error == 0) return connected_ = true;
      close_descriptor();
      return false;
    }
    if (now_us < next_attempt_us_) return false;
    next_attempt_us_ = now_us + kRetryPeriod;
    descriptor_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (descriptor_ < 0) return false;
    set_no_delay(descriptor_);
    if (::connect(descriptor_, reinterpret_cast<const sockaddr*>(&address_), sizeof address_) == 0)
      return connected_ = true;
    if (errno != EINPROGRESS) close_descriptor();
    return false;
  }

 private:
  sockaddr_in address_{};
  int64_t next_attempt_us_ = 0;
  bool connected_ = false;
};

/// Accepts one connection at a time.
class TcpListener : public DescriptorTransport {
 public:
  explicit TcpListener(int port) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    const int on = 1;
    ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        ::listen(listener_, 1) != 0)
      throw InputError("port " + std::to_string(port) + " cannot be listened on: " + strerror(errno));
  }
  ~TcpListener() override { ::close(listener_); }
  TcpListener(const TcpListener&) = delete;
  TcpListener& operator=(const TcpListener&) = delete;

  bool open(int64_t) override {
    if (descriptor_ >= 0) return true;
    descriptor_ = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (descriptor_ >= 0) set_no_delay(descriptor_);
    return descriptor_ >= 0;
  }

 private:
  int listener_ = -1;
};

speed_t baud_constant(int baud) {
  static constexpr std::array<std::pair<int, speed_t>, 9> kRates{{{9600, B9600},
                                                                  {57600, B57600},
                                                                  {115200, B115200},
                                                                  {500000, B500000},
                                                                  {1000000, B1000000},
                                                                  {2000000, B2000000},
                                                                  {3000000, B3000000},
                                                                  {4000000, B4000000},
                                                                  {230400, B230400}}};
  for (const auto& [rate, constant] : kRates) {
    if (rate == baud) return constant;
  }
  throw InputError("driver.baud: " + std::to_string(baud) + " is not a rate of serial ports");
}

/// Eight data bits, no parity, nothing changed on the way.
void set_raw(int descriptor, speed_t baud) {
  termios settings{};
  if (::tcgetattr(descriptor, &settings) != 0) return;
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  ::cfsetspeed(&settings, baud);
  ::tcsetattr(descriptor, TCSANOW, &settings);
}

/// Motor commands must not get into a file that `driver.device` names by mistake.
class SerialPort : public DescriptorTransport {
 public:
  SerialPort(std::string device, int baud) : device_(std::move(device)), baud_(baud_constant(baud)) {
    struct stat found {};
    if (::stat(device_.c_str(), &found) == 0 && !S_ISCHR(found.st_mode))
      throw InputError("driver.device: '" + device_ + "' is no serial port");
  }

  bool open(int64_t now_us) override {
    if (descriptor_ >= 0) return true;
    if (now_us < next_attempt_us_) return false;
    next_attempt_us_ = now_us + kRetryPeriod;
    struct stat found {};  // it may have been absent at the start, and opening a pipe has effects
    if (::stat(device_.c_str(), &found) != 0 || !S_ISCHR(found.st_mode)) return false;
    descriptor_ = ::open(device_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (descriptor_ >= 0 && !::isatty(descriptor_)) close_descriptor();
    if (descriptor_ >= 0) {
      set_raw(descriptor_, baud_);
      ::tcflush(descriptor_, TCIOFLUSH);
    }
    return descriptor_ >= 0;
  }
  /// A serial port at rest reads as its end.
  bool receive(std::vector<uint8_t>& bytes) override {
    errno = 0;
    return DescriptorTransport::receive(bytes) || (descriptor_ >= 0 && errno == 0);
  }

 private:
  std::string device_;
  speed_t baud_;
  int64_t next_attempt_us_ = 0;
};

class PseudoTerminal : public DescriptorTransport {
 public:
  explicit PseudoTerminal(std::string path) : path_(std::move(path)) {
    descriptor_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (descriptor_ < 0 || ::grantpt(descriptor_) != 0 || ::unlockpt(descriptor_) != 0)
      throw InputError(std::string("no pseudo-terminal can be made: ") + strerror(errno));
    device_ = ::ptsname(descriptor_);
    // Kept open, so that the terminal persists while no driver has opened it.
    slave_ = ::open(device_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    set_raw(slave_, B1000000);
    if (is_left_behind()) ::unlink(path_.c_str());
    if (::symlink(device_.c_str(), path_.c_str()) == 0) return;
    const int error = errno;
    ::close(slave_);
    throw InputError("the emulated serial port cannot be made: '" + path_ + "'" +
                     (error == EEXIST ? " exists" : std::string(": ") + strerror(error)) +
                     "; --device names another path, for emulator and driver");
  }
  ~PseudoTerminal() override {
    ::close(slave_);
    std::error_code error;
    if (std::filesystem::read_symlink(path_, error) == device_) ::unlink(path_.c_str());
  }
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  bool open(int64_t) override { return true; }
  void close() override {}

 private:
  /// Whether the path is a link to a pseudo-terminal that is gone, of an emulator that was killed.
  bool is_left_behind() const {
    std::error_code error;
    const std::string target = std::filesystem::read_symlink(path_, error).string();
    return !error && target.starts_with("/dev/pts/") && (target == device_ || ::access(target.c_str(), F_OK) != 0);
  }

  std::string path_, device_;
  int slave_ = -1;
};

}  // namespace

Transports client_transports(const std::vector<Link>& links) {
  Transports transports;
  for (const Link& link : links) {
    if (link.kind == Link::Kind::kTcp) {
      transports.push_back(std::make_unique<TcpClient>(link.address, link.number));
    } else if (link.kind == Link::Kind::kSerial) {
      transports.push_back(std::make_unique<SerialPort>(link.address, link.number));
    } else {
      transports.push_back(nullptr);
    }
  }
  return transports;
}

Transports emulator_transports(const std::vector<Link>& links) {
  Transports transports;
  for (const Link& link : links) {
    if (link.kind == Link::Kind::kTcp) {
      transports.push_back(std::make_unique<TcpListener>(link.number));
    } else if (link.kind == Link::Kind::kSerial) {
      transports.push_back(std::make_unique<PseudoTerminal>(link.address));
    } else {
      transports.push_back(nullptr);
    }
  }
  return transports;
}

}  // namespace multireach::drivers
