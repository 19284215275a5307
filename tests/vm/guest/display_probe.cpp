// Shows masks on a real kernel's display output, for the tests in a virtual machine: does the commands of its
// arguments in turn and prints a line for each.
//   check            what --check-hardware says
//   open             takes the display (as every command below does that needs it)
//   show:SEED        a mask of random greys; prints its CRC-32 as the display's log has it, and when it was
//   shown show-part:SEED   the same, changing a tenth of the rows only black            prints when black-now
//   alone, or as show:SEED,black-now: while the mask still waits for its refresh flips:N          N masks one
//   after the other; prints how many a second, and the longest interval lose-master      as if another
//   program took the card wait:MS          the event loop goes on; disturbances are printed until-lost,
//   until-back close            gives the display back die              by SIGKILL
// Options before them: --card C, --connector C, --mode WxH@HZ, --legacy, --rgb565, --buffers N
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>
#include <xf86drm.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <list>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "hw/drm/drm_display.hpp"

namespace {

long allocations = 0;  // by operator new, of the whole program; one thread

}  // namespace

void* operator new(std::size_t bytes) {
  ++allocations;
  if (void* memory = std::malloc(bytes != 0 ? bytes : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

using namespace contourd;

namespace {

using Milliseconds = std::chrono::milliseconds;

TimePoint now() {
  return std::chrono::time_point_cast<Duration>(std::chrono::steady_clock::now());
}

// An event loop of its own: poll(2) over what is watched.
class PollLoop final : public DescriptorWatcher {
 public:
  std::unique_ptr<Watch> when_readable(int fd, std::function<void()> call) override {
    return std::make_unique<Entry>(*this, fd, std::move(call));
  }

  // Runs what is ready, waiting for it until `end` at most.
  void turn(TimePoint end) {
    std::vector<pollfd> fds;
    for (const Entry* entry : entries_)
      fds.push_back({entry->fd, POLLIN, 0});
    const auto left = std::chrono::ceil<Milliseconds>(end - now());
    if (::poll(fds.data(), fds.size(), static_cast<int>(std::max<long>(left.count(), 0))) <= 0) return;
    for (const pollfd& ready : fds) {
      if (ready.revents == 0) continue;
      const auto entry = std::ranges::find(entries_, ready.fd, &Entry::fd);
      if (entry != entries_.end()) (*entry)->call();
    }
  }

 private:
  struct Entry final : Watch {
    Entry(PollLoop& in, int watched, std::function<void()> to_call)
        : loop(in), fd(watched), call(std::move(to_call)) {
      loop.entries_.push_back(this);
    }
    ~Entry() override { loop.entries_.remove(this); }
    PollLoop& loop;
    int fd;
    std::function<void()> call;
  };
  std::list<Entry*> entries_;
};

std::uint32_t crc32_of_shown(const Mask& mask, PixelFormat format) {
  static const auto table = [] {
    std::array<std::uint32_t, 256> made{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t c = i;
      for (int bit = 0; bit < 8; ++bit)
        c = (c & 1U) != 0 ? 0xedb88320U ^ c >> 1U : c >> 1U;
      made[i] = c;
    }
    return made;
  }();
  std::uint32_t crc = ~0U;
  for (const std::uint8_t grey : mask.pixels()) {
    const std::uint32_t word = format == PixelFormat::Xrgb8888 ? xrgb8888(grey) : rgb565(grey);
    for (std::size_t byte = 0; byte < bytes_per_pixel(format); ++byte)
      crc = table[(crc ^ word >> 8 * byte) & 0xffU] ^ crc >> 8U;
  }
  return ~crc;
}

class Probe {
 public:
  explicit Probe(DrmDisplayConfig config)
      : config_(std::move(config)), mask_(config_.width, config_.height) {}

  void run(const std::string& command) {
    const auto colon = command.find(':');
    const std::string name = command.substr(0, colon);
    const int argument = colon == std::string::npos ? 0 : std::atoi(command.c_str() + colon + 1);
    if (name == "check") return say(describe(check_drm_display(config_)));
    if (name == "close") return display_.reset();
    if (name == "die") ::kill(::getpid(), SIGKILL);
    if (name == "wait") return loop_until(Milliseconds{argument}, [] { return false; });
    if (!display_) open();
    if (name == "open") return;
    if (name == "show") return show(argument, command.ends_with(",black-now"), 0, config_.height.count());
    if (name == "show-part") return show(argument, false, 400, 508);
    if (name == "black") return black();
    if (name == "black-now") return display_->black_now();
    if (name == "flips") return flips(argument);
    if (name == "lose-master") return lose_master();
    if (name == "until-lost") return until([this] { return display_->problem().has_value(); });
    if (name == "until-back") return until([this] { return !display_->problem(); });
    throw std::runtime_error("no command " + name);
  }

 private:
  static void say(const std::string& text) { std::printf("%s\n", text.c_str()); }

  void open() {
    display_ = std::make_unique<DrmDisplay>(loop_, config_);
    display_->on_disturbance([](const Disturbance& disturbance) { say("DISTURBANCE " + disturbance.what); });
    say("OPEN " + display_->description() + " " + display_->problem().value_or("ok"));
    if (display_->warning()) say("WARNING " + *display_->warning());
  }

  template <typename Condition>
  void loop_until(Duration longest, const Condition& condition) {
    for (const TimePoint end = now() + longest; !condition() && now() < end;)
      loop_.turn(end);
  }

  template <typename Condition>
  void until(const Condition& condition) {
    loop_until(Milliseconds{20'000}, condition);
    say(display_->problem() ? "LOST " + *display_->problem() : "BACK");
  }

  void paint(int seed, int from_row, int end_row) {
    auto random = static_cast<std::uint32_t>(seed) * 2654435761U + 1;
    for (int y = from_row; y < end_row && y < mask_.height().count(); ++y) {
      for (std::uint8_t& grey : mask_.row(y)) {
        random = random * 1664525U + 1013904223U;
        grey = static_cast<std::uint8_t>(random >> 24U);
      }
    }
  }

  MaskDisplay::Presented on_presented() {
    answered_ = false;
    return [this](std::optional<TimePoint> at) {
      answered_ = true;
      presented_ = at;
    };
  }

  void await_presented(const std::string& what) {
    loop_until(Milliseconds{5'000}, [this] { return answered_; });
    if (!answered_) throw std::runtime_error(what + ": no answer");
    const std::string when =
        presented_ ? std::to_string(presented_->time_since_epoch().count()) : std::string("nothing");
    say(what + " at " + when + " now " + std::to_string(now().time_since_epoch().count()));
  }

  void show(int seed, bool then_black_now, int from_row, int end_row) {
    paint(seed, from_row, end_row);
    const TimePoint begin = now();
    auto done = on_presented();
    const long before = allocations;
    display_->show(mask_, std::move(done));
    const long allocated = allocations - before;
    const auto took = std::chrono::duration_cast<std::chrono::microseconds>(now() - begin);
    char text[128];
    std::snprintf(text, sizeof text, "SHOW %08x %lld lit, %zu bytes, %ld us, %ld allocations",
                  crc32_of_shown(mask_, config_.format), static_cast<long long>(mask_.lit_pixels()),
                  display_->bytes_written(), static_cast<long>(took.count()), allocated);
    if (!then_black_now) return await_presented(text);
    display_->black_now();
    say(std::string(text) + ", then black");
  }

  void black() {
    display_->black(on_presented());
    await_presented("BLACK");
  }

  void flips(int count) {
    TimePoint first{}, last{};
    Duration longest{};
    for (int i = 0; i < count; ++i) {
      paint(i, 500, 508);
      display_->show(mask_, on_presented());
      loop_until(Milliseconds{5'000}, [this] { return answered_; });
      if (!answered_ || !presented_) throw std::runtime_error("flip " + std::to_string(i) + " was not shown");
      if (i == 0) first = *presented_;
      if (i > 0) longest = std::max(longest, *presented_ - last);
      last = *presented_;
    }
    const double seconds = std::chrono::duration<double>(last - first).count();
    char text[96];
    std::snprintf(text, sizeof text, "FLIPS %d, %.2f a second, longest interval %.3f ms", count,
                  (count - 1) / seconds, std::chrono::duration<double, std::milli>(longest).count());
    say(text);
  }

  // DRM master goes with the open file: dropping it on the display's own descriptor is what the kernel does
  // when another program is given the card.
  void lose_master() {
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
      std::error_code gone;
      const std::string target = std::filesystem::read_symlink(entry.path(), gone);
      if (target.starts_with("/dev/dri/card")) drmDropMaster(std::atoi(entry.path().filename().c_str()));
      if (target.starts_with("/dev/dri/card")) taken_by_ = ::open(target.c_str(), O_RDWR | O_CLOEXEC);
      if (taken_by_ >= 0) return say("LOST MASTER");
    }
  }

  DrmDisplayConfig config_;
  Mask mask_;
  PollLoop loop_;
  std::unique_ptr<DrmDisplay> display_;
  bool answered_ = false;
  std::optional<TimePoint> presented_;
  int taken_by_ = -1;  // another open file of the card, until the process ends
};

DrmDisplayConfig config_from(std::vector<std::string>& arguments) {
  DrmDisplayConfig config;
  const auto next = [&] {
    std::string argument = arguments.front();
    arguments.erase(arguments.begin());
    return argument;
  };
  while (!arguments.empty() && arguments.front().starts_with("--")) {
    const std::string option = next();
    if (option == "--legacy") config.legacy = true;
    if (option == "--rgb565") config.format = PixelFormat::Rgb565;
    if (option == "--card") config.card = next();
    if (option == "--connector") config.connector = next();
    if (option == "--buffers") config.buffers = std::stoi(next());
    if (option != "--mode") continue;
    int width = 0, height = 0;
    if (std::sscanf(next().c_str(), "%dx%d@%lf", &width, &height, &config.refresh_hz) != 3)
      throw std::runtime_error("--mode is WxH@HZ");
    config.width = Pixels{width};
    config.height = Pixels{height};
  }
  return config;
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  try {
    std::vector<std::string> arguments(argv + 1, argv + argc);
    Probe probe(config_from(arguments));
    for (const std::string& command : arguments)
      probe.run(command);
    return 0;
  } catch (const std::exception& error) {
    std::printf("ERROR %s\n", error.what());
    return 1;
  }
}
