#include "daemon/camera/camera_call.hpp"

#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>

#include "hw/file_descriptor.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

// The service at the other end of the socket: keeps what it is sent, and sends an answer.
class CameraListener {
 public:
  explicit CameraListener(const std::filesystem::path& path)
      : socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.native().copy(static_cast<char*>(address.sun_path), sizeof address.sun_path - 1);
    REQUIRE(::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(::listen(socket_.get(), 8) == 0);
  }
  // Answers the next call on a thread.
  void answer(std::string bytes) {
    thread_ = std::jthread([this, bytes = std::move(bytes)] {
      const FileDescriptor connection(::accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC));
      std::array<char, 4096> buffer{};
      for (ssize_t got = 0; (got = ::read(connection.get(), buffer.data(), buffer.size())) > 0;)
        heard.append(buffer.data(), static_cast<std::size_t>(got));
      std::string_view left = bytes;
      while (!left.empty()) {
        const ssize_t sent = ::send(connection.get(), left.data(), left.size(), MSG_NOSIGNAL);
        if (sent < 0) return;
        left.remove_prefix(static_cast<std::size_t>(sent));
      }
    });
  }
  void join() { thread_.join(); }

  std::string heard;

 private:
  FileDescriptor socket_;
  std::jthread thread_;
};

class CameraCallFixture {
 public:
  CameraAnswer call() { return call_camera({path, {{"JOB", "a part"}, {"LAYER", "7"}}, 60s}, stop.get()); }
  CameraAnswer answered(std::string bytes) {
    listener.answer(std::move(bytes));
    const CameraAnswer answer = call();
    listener.join();
    return answer;
  }

  testing::TemporaryFolder folder;
  std::filesystem::path path = folder.path() / "camera.socket";
  CameraListener listener{path};
  FileDescriptor stop{::eventfd(0, EFD_CLOEXEC)};
};

}  // namespace

TEST_CASE_METHOD(CameraCallFixture, "The camera gets its variables and its file is returned") {
  const std::string picture = "\xff\xd8\xff" + std::string(300'000, '\0') + "end";
  const CameraAnswer answer = answered(picture);
  CHECK(answer.trouble.empty());
  CHECK(answer.bytes == picture);
  CHECK(is_jpeg(answer.bytes));
  using namespace std::string_literals;
  CHECK(listener.heard == "CONTOURD_JOB=a part\0CONTOURD_LAYER=7\0"s);
}

TEST_CASE_METHOD(CameraCallFixture, "A camera's answer without a file says why there is none") {
  CHECK(answered("").trouble == "its command has sent nothing");
  CHECK(answered("trouble: the command ended with status 3\n").trouble == "the command ended with status 3");
  CHECK(answered("trouble: \x1b[2Jred").trouble == "?[2Jred");
  CHECK(answered("trouble: " + std::string(5'000, 'x')).trouble.size() == 200);
  const CameraAnswer none = answered("none\n");
  CHECK(none.trouble.empty());
  CHECK(none.bytes.empty());
}

TEST_CASE_METHOD(CameraCallFixture, "A camera's file of up to 8 MiB is taken") {
  CHECK(answered(std::string(kMostCameraBytes, 'x')).bytes.size() == kMostCameraBytes);
  CHECK(answered(std::string(kMostCameraBytes + 1, 'x')).trouble == "its command has sent more than 8 MiB");
}

TEST_CASE_METHOD(CameraCallFixture,
                 "A camera that does not answer is left after the patience, or at a stop") {
  // The listener's queue takes the call, but no one answers it.
  SECTION("patience") {
    CHECK(
        call_camera({path, {}, 50ms}, stop.get()).trouble.starts_with("its service has not answered within"));
  }
  SECTION("stop") {
    REQUIRE(::eventfd_write(stop.get(), 1) == 0);
    CHECK(call().trouble == "contourd stops");
  }
}

TEST_CASE("Without a camera's service the trouble says how to enable it") {
  const testing::TemporaryFolder folder;
  const FileDescriptor stop(::eventfd(0, EFD_CLOEXEC));
  const CameraAnswer answer = call_camera({folder.path() / "nowhere", {}, 60s}, stop.get());
  CHECK_THAT(answer.trouble, Catch::Matchers::Contains("systemctl enable --now contourd-camera.socket"));
}

TEST_CASE("Files of other kinds are neither JPEG nor MP4") {
  CHECK(is_jpeg("\xff\xd8\xff\xe0"));
  for (const char* other : {"", "\xff\xd8", "\x89PNG", "<html>"})
    CHECK_FALSE(is_jpeg(other));
  CHECK(
      is_mp4(std::string_view("\0\0\0\x20"
                              "ftypisom",
                              12)));
  for (const char* other : {"", "ftyp", "1234", "1234moov"})
    CHECK_FALSE(is_mp4(other));
}

}  // namespace contourd
