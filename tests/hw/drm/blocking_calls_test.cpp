#include "hw/drm/blocking_calls.hpp"

#include <poll.h>

#include <future>
#include <thread>

#include "tests/catch.hpp"

namespace {

// Watches one descriptor as an event loop would.
class OneDescriptor final : public DescriptorWatcher {
 public:
  [[nodiscard]] std::unique_ptr<Watch> when_readable(int fd, std::function<void()> call) override {
    fd_ = fd;
    call_ = std::move(call);
    return std::make_unique<Watch>();
  }
  void wait() {
    pollfd wanted{fd_, POLLIN, 0};
    REQUIRE(::poll(&wanted, 1, 10'000) == 1);
    call_();
  }
  [[nodiscard]] bool is_readable() const {
    pollfd wanted{fd_, POLLIN, 0};
    return ::poll(&wanted, 1, 0) == 1;
  }

 private:
  int fd_ = -1;
  std::function<void()> call_;
};

}  // namespace

TEST_CASE("Blocking calls run on a thread of their own, and their results arrive on the loop's, in order") {
  OneDescriptor loop;
  BlockingCalls calls(loop);
  const auto here = std::this_thread::get_id();
  std::promise<void> go;
  std::vector<int> results;
  calls.run(
      [here, wait = go.get_future().share()] {
        wait.wait();
        return std::this_thread::get_id() == here ? -1 : 1;
      },
      [&](int result) {
        CHECK(std::this_thread::get_id() == here);
        results.push_back(result);
      });
  calls.run([] { return 2; }, [&](int result) { results.push_back(result); });
  CHECK_FALSE(loop.is_readable());
  go.set_value();
  while (results.size() < 2)
    loop.wait();
  CHECK(results == std::vector{1, 2});
  // A result may be taken before the thread has signalled it; the signal then finds no further result.
  while (loop.is_readable())
    loop.wait();
  CHECK(results.size() == 2);
}

TEST_CASE("The destructor waits for the running call and delivers no result") {
  OneDescriptor loop;
  std::promise<void> begun, go;
  bool ended = false, handed_back = false;
  const auto kept = std::make_shared<int>(1);
  auto calls = std::make_unique<BlockingCalls>(loop);
  calls->run(
      [&, kept] {
        begun.set_value();
        go.get_future().wait();
        ended = true;
        return kept;
      },
      [&](const auto&) { handed_back = true; });
  begun.get_future().wait();
  std::jthread end([&] { calls.reset(); });
  go.set_value();
  end.join();
  CHECK(ended);
  CHECK_FALSE(handed_back);
  CHECK(kept.use_count() == 1);
}
