#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>

#include "camera/devices/v4l2_device.hpp"
#include "runtime/message_clock.hpp"

namespace multireach {
namespace {

class KernelCalls : public DeviceCalls {
 public:
  int open(const std::string& path) override { return ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC); }
  int close(int file) override { return ::close(file); }
  int ioctl(int file, unsigned long request, void* argument) override {
    int result = 0;
    do {
      result = ::ioctl(file, request, argument);
    } while (result < 0 && errno == EINTR);
    return result;
  }
  void* map(int file, size_t length, off_t offset) override {
    void* memory = ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, file, offset);
    return memory == MAP_FAILED ? nullptr : memory;
  }
  void unmap(void* memory, size_t length) override { ::munmap(memory, length); }
  int wait(int file, int64_t timeout_us) override {
    pollfd wait{file, POLLIN, 0};
    return ::poll(&wait, 1, static_cast<int>((timeout_us + 999) / 1000));
  }
  int64_t monotonic_us() override { return multireach::monotonic_us(); }
};

}  // namespace

DeviceCalls& kernel_calls() {
  static KernelCalls calls;
  return calls;
}

}  // namespace multireach
