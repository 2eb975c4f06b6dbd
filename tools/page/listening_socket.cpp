#include "tools/page/listening_socket.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "runtime/files.hpp"

namespace multireach {
namespace {

constexpr int kBacklog = 64;
constexpr int kFirstDescriptor = 100;  // scripts use small descriptors for their own files

/// The port of a listening IPv4 socket; 0 for any other descriptor.
int port_or_zero(int socket) {
  int listens = 0;
  socklen_t size = sizeof listens;
  if (getsockopt(socket, SOL_SOCKET, SO_ACCEPTCONN, &listens, &size) != 0 || !listens) return 0;
  sockaddr_in address{};
  size = sizeof address;
  if (getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0 || address.sin_family != AF_INET) return 0;
  return ntohs(address.sin_port);
}

}  // namespace

int open_listening_socket(const std::string& address, int port) {
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(static_cast<uint16_t>(port));
  if (inet_pton(AF_INET, address.c_str(), &name.sin_addr) != 1)
    throw InputError("'" + address + "' is no IPv4 address, e.g. 127.0.0.1");
  const int first = ::socket(AF_INET, SOCK_STREAM, 0);
  const int yes = 1;
  setsockopt(first, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (bind(first, reinterpret_cast<const sockaddr*>(&name), sizeof name) != 0 || listen(first, kBacklog) != 0) {
    const std::string reason = std::strerror(errno);
    if (first >= 0) ::close(first);
    throw InputError("the page cannot be served at " + address + ":" + std::to_string(port) + " (" + reason + ")");
  }
  const int socket = fcntl(first, F_DUPFD, kFirstDescriptor);
  if (socket < 0) return first;
  ::close(first);
  return socket;
}

int listening_port(int socket) {
  const int port = port_or_zero(socket);
  if (port == 0) throw InputError("descriptor " + std::to_string(socket) + " is no socket that listens over IPv4");
  return port;
}

int replace_listening_socket(int own_port, int socket) {
  const int port = listening_port(socket);
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int own = std::stoi(entry.path().filename());
    if (own == socket || port_or_zero(own) != own_port) continue;
    const int flags = fcntl(socket, F_GETFL);
    fcntl(socket, F_SETFL, flags | O_NONBLOCK);  // a client that has gone again must not block accept()
    if (dup2(socket, own) < 0) break;
    return port;
  }
  throw InputError("this process does not listen at port " + std::to_string(own_port));
}

void run_instead(const std::vector<std::string>& command) {
  std::vector<char*> words;
  for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  execvp(words[0], words.data());
  throw InputError("'" + command.at(0) + "' cannot be run: " + std::strerror(errno));
}

}  // namespace multireach
