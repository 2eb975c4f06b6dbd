#include "runtime/files.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "runtime/config.hpp"
#include "runtime/log_file.hpp"
#include "tests/temporary_folder.hpp"

namespace multireach {
namespace {

class Files : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }

  static std::string fault(const std::function<void()>& read) {
    try {
      read();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  static std::vector<uint8_t> bytes(const std::string& text) { return {text.begin(), text.end()}; }

  const testing::TemporaryFolder folder_;
};

TEST_F(Files, RefusesAtOnceWhatIsNoRegularFileOfABoundedSize) {
  ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
  std::filesystem::create_directory(path("folder"));
  // Sparse: takes no space.
  ASSERT_EQ(close(open(path("large").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600)), 0);
  std::filesystem::resize_file(path("large"), uintmax_t{10} << 30);
  const std::pair<std::string, std::string> cases[]{{"/dev/zero", "is a device or a pipe; a regular file is expected"},
                                                    {path("pipe"), "is a device or a pipe; a regular file is expected"},
                                                    {path("folder"), "is a folder, not a file"}};
  for (const auto& [file, words] : cases) {
    EXPECT_EQ(fault([&, name = file] { Config::load(name); }), file + ": " + words);
    EXPECT_EQ(fault([&, name = file] { load_chain(name, "a", "b"); }), file + ": " + words);
    EXPECT_EQ(fault([&, name = file] { read_binary_file(name); }), file + ": " + words);
    EXPECT_EQ(fault([&, name = file] { LogReader{name}; }), file + ": " + words);
  }
  const std::string large = path("large");
  EXPECT_EQ(fault([&] { Config::load(large); }), large + ": has 10240 MB; at most 16 MB are read");
  EXPECT_EQ(fault([&] { load_chain(large, "a", "b"); }), large + ": has 10240 MB; at most 16 MB are read");
  EXPECT_EQ(fault([&] { read_binary_file(large); }), large + ": has 10240 MB; at most 1024 MB are read");
  EXPECT_EQ(fault([&] { LogReader{large}; }), large + ": holds no event of an LCM log in its first 256 MB");
  EXPECT_NE(fault([] { Config::parse("large.yaml", std::string((4 << 20) + 1, ' ')); }).find("larger than 4 MB"),
            std::string::npos);
}

TEST_F(Files, ReadsWhatTheKernelGivesWithoutASize) {
  EXPECT_NE(read_text_file("/proc/self/status").find("VmRSS"), std::string::npos);
}

TEST_F(Files, AFullDeviceIsAnErrorThatNamesIt) {
  const std::vector<uint8_t> some = bytes("some text");
  OutputFile file("/dev/full");
  try {
    file.write(some);
    FAIL() << "nothing can be written there";
  } catch (const OutputError& error) {
    EXPECT_STREQ(error.what(), "/dev/full: cannot be written (No space left on device)");
  }
  EXPECT_THROW(write_text_file("/dev/full", "text"), OutputError);
  EXPECT_THROW(write_text_file("/nowhere/file", "text"), InputError);
}

TEST_F(Files, AnOutputReplacesTheOldFileOnlyWhenItIsFinished) {
  write_text_file(path("out"), "old");
  {
    OutputFile file(path("out"));
    file.write(bytes("new"));
  }
  EXPECT_EQ(read_text_file(path("out")), "old");
  OutputFile file(path("out"));
  file.write(bytes("new"));
  file.finish();
  EXPECT_EQ(read_text_file(path("out")), "new");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 1);
}

TEST_F(Files, ASignalThatEndsTheProgramLeavesNoTemporaryFile) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    const pid_t child = fork();
    if (child == 0) {
      std::signal(number, SIG_DFL);
      OutputFile finished(path("finished")), file(path("out")), other(path("other"));
      finished.finish();
      file.write(bytes("half"));
      raise(number);
      _exit(0);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == number) << "as if there had been no file";
    EXPECT_TRUE(std::filesystem::remove(path("finished")));
    EXPECT_TRUE(std::filesystem::is_empty(folder_.path())) << "signal " << number;
  }
}

}  // namespace
}  // namespace multireach
