#pragma once

#include <string>
#include <vector>

namespace multireach {

/// A TCP socket that listens at an IPv4 address and a port (0: any that is free); child processes inherit it. Throws
/// InputError.
int open_listening_socket(const std::string& address, int port);
/// The port that a socket listens at. Throws InputError when it is no such socket.
int listening_port(int socket);

/// Puts `socket` in the place of this process's own socket that listens at `own_port`: whatever accepts connections
/// there then accepts those of `socket`. Returns the new port. Throws InputError when either is no listening socket.
int replace_listening_socket(int own_port, int socket);

/// Replaces this program by another one, found as the shell finds it. Throws InputError when that is not possible.
[[noreturn]] void run_instead(const std::vector<std::string>& command);

}  // namespace multireach
