#include "hw/drm/frame_writer.hpp"

#include <signal.h>
#include <sys/mman.h>
#include <ucontext.h>

#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

namespace {

// A picture's memory in pages of its own. Like a card's memory it has a stride longer than its rows.
class Pages {
 public:
  Pages(Pixels width, Pixels height, PixelFormat format)
      : layout{width, height, static_cast<std::size_t>(width.count()) * bytes_per_pixel(format) + 64, format},
        size_(layout.stride_bytes * static_cast<std::size_t>(height.count())),
        memory_(static_cast<std::byte*>(
            ::mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0))) {
    REQUIRE(memory_ != MAP_FAILED);
  }
  ~Pages() { ::munmap(memory_, size_); }
  Pages(const Pages&) = delete;
  Pages& operator=(const Pages&) = delete;

  [[nodiscard]] std::span<std::byte> memory() const { return {memory_, size_}; }
  [[nodiscard]] std::uint32_t pixel(std::int32_t x, std::int32_t y) const {
    std::uint32_t word = 0;
    const std::size_t bytes = bytes_per_pixel(layout.format);
    std::memcpy(
        &word,
        memory_ + static_cast<std::size_t>(y) * layout.stride_bytes + static_cast<std::size_t>(x) * bytes,
        bytes);
    return word;
  }

  FrameWriter::Layout layout;

 private:
  std::size_t size_;
  std::byte* memory_;
};

std::uint32_t naive(std::uint8_t grey, PixelFormat format) {
  if (format == PixelFormat::Xrgb8888) return static_cast<std::uint32_t>(grey << 16 | grey << 8 | grey);
  const int five = static_cast<int>(grey * 31.0 / 255.0 + 0.5),
            six = static_cast<int>(grey * 63.0 / 255.0 + 0.5);
  return static_cast<std::uint32_t>(five << 11 | six << 5 | five);
}

bool shows(const Pages& pages, const Mask& mask) {
  for (std::int32_t y = 0; y < mask.height().count(); ++y) {
    for (std::int32_t x = 0; x < mask.width().count(); ++x) {
      if (pages.pixel(x, y) != naive(mask.row(y)[static_cast<std::size_t>(x)], pages.layout.format))
        return false;
    }
  }
  return true;
}

// Changes some stretches of the mask.
void change(Mask& mask) {
  for (auto stretches = testing::draw(0, 5); stretches > 0; --stretches) {
    const auto row = mask.row(static_cast<std::int32_t>(testing::draw(0, mask.height().count() - 1)));
    const auto from = testing::draw(0, mask.width().count() - 1);
    const auto end = testing::draw(from, mask.width().count());
    const auto grey = static_cast<std::uint8_t>(testing::draw(0, 255));
    std::fill(row.begin() + from, row.begin() + end, grey);
  }
}

PixelFormat draw_format() {
  return testing::draw(0, 1) == 0 ? PixelFormat::Xrgb8888 : PixelFormat::Rgb565;
}

struct Sizes {
  Pixels width, height;
};
Sizes draw_sizes() {
  return {Pixels{static_cast<std::int32_t>(testing::draw(1, 200))},
          Pixels{static_cast<std::int32_t>(testing::draw(1, 20))}};
}

// Returns the bytes of the blocks in which two masks differ. The rest of a row after its last whole block is
// counted pixel by pixel.
std::size_t bytes_that_differ(const Mask& a, const Mask& b, PixelFormat format) {
  std::size_t pixels = 0;
  const auto width = static_cast<std::size_t>(a.width().count());
  for (std::int32_t y = 0; y < a.height().count(); ++y) {
    for (std::size_t x = 0; x < width;) {
      const std::size_t length = x + FrameWriter::kBlock <= width ? FrameWriter::kBlock : 1;
      if (!std::ranges::equal(a.row(y).subspan(x, length), b.row(y).subspan(x, length))) pixels += length;
      x += length;
    }
  }
  return pixels * bytes_per_pixel(format);
}

}  // namespace

TEST_CASE("After any sequence of masks the picture equals a pixel-by-pixel conversion of the last") {
  CHECK(rc::check([] {
    const Sizes sizes = draw_sizes();
    const Pages pages(sizes.width, sizes.height, draw_format());
    FrameWriter writer(pages.layout, pages.memory());
    Mask mask(sizes.width, sizes.height);
    for (auto masks = testing::draw(1, 6); masks > 0; --masks) {
      change(mask);
      writer.write(mask);
      RC_ASSERT(shows(pages, mask));
      RC_ASSERT(writer.content() == mask);
    }
  }));
}

TEST_CASE("Only blocks that differ are written, and write() returns their bytes") {
  CHECK(rc::check([] {
    const Sizes sizes = draw_sizes();
    const Pages pages(sizes.width, sizes.height, draw_format());
    FrameWriter writer(pages.layout, pages.memory());
    Mask mask(sizes.width, sizes.height);
    change(mask);
    writer.write(mask);
    const Mask before = mask;
    change(mask);
    // A mark in all bytes shows which of them were written.
    std::ranges::fill(pages.memory(), std::byte{0xa5});
    const std::size_t written = writer.write(mask);
    RC_ASSERT(written == bytes_that_differ(before, mask, pages.layout.format));
    const auto touched = static_cast<std::size_t>(
        std::ranges::count_if(pages.memory(), [](std::byte byte) { return byte != std::byte{0xa5}; }));
    RC_ASSERT(touched <= written);  // a pixel may happen to look like the mark
  }));
}

TEST_CASE("Writing the same mask again writes no bytes") {
  const Pages pages(Pixels{64}, Pixels{4}, PixelFormat::Xrgb8888);
  FrameWriter writer(pages.layout, pages.memory());
  Mask mask(Pixels{64}, Pixels{4});
  mask.row(2)[17] = 200;
  CHECK(writer.write(mask) == 64);  // one block of 16 pixels
  CHECK(writer.write(mask) == 0);
}

TEST_CASE("A picture is black from the start, whatever the memory held") {
  const Pages pages(Pixels{30}, Pixels{4}, PixelFormat::Rgb565);
  std::ranges::fill(pages.memory(), std::byte{0xff});
  FrameWriter writer(pages.layout, pages.memory());
  CHECK(shows(pages, Mask(Pixels{30}, Pixels{4})));
}

TEST_CASE("A picture is black after blacken(), and the next mask is written whole") {
  const Pages pages(Pixels{48}, Pixels{4}, PixelFormat::Xrgb8888);
  FrameWriter writer(pages.layout, pages.memory());
  Mask mask(Pixels{48}, Pixels{4});
  std::ranges::fill(mask.row(1), std::uint8_t{255});
  writer.write(mask);
  writer.blacken();
  CHECK(shows(pages, Mask(Pixels{48}, Pixels{4})));
  CHECK(writer.write(mask) == 48 * 4);
  CHECK(shows(pages, mask));
}

TEST_CASE("In RGB565 full light has all bits set and dark has none") {
  CHECK(rgb565(255) == 0xffff);
  CHECK(rgb565(0) == 0);
}

#ifdef __x86_64__

namespace {

// x86 has no memory that can be written but not read. So the pages are protected and every access faults. The
// fault's error code tells a read from a write; then the pages are opened for that one instruction.
class ClosedPages {
 public:
  explicit ClosedPages(std::span<std::byte> memory) {
    pages = memory;
    accesses = reads = 0;
    struct sigaction action {};
    action.sa_flags = SA_SIGINFO;
    action.sa_sigaction = on_access;
    ::sigaction(SIGSEGV, &action, &former_fault_);
    action.sa_sigaction = after_access;
    ::sigaction(SIGTRAP, &action, &former_trap_);
    ::mprotect(pages.data(), pages.size(), PROT_NONE);
  }
  ~ClosedPages() {
    ::mprotect(pages.data(), pages.size(), PROT_READ | PROT_WRITE);
    ::sigaction(SIGSEGV, &former_fault_, nullptr);
    ::sigaction(SIGTRAP, &former_trap_, nullptr);
  }

  static inline long accesses = 0, reads = 0;

 private:
  static constexpr greg_t kWriteAccess = 1 << 1;  // Intel SDM volume 3, 4.7: page-fault error code
  static constexpr greg_t kTrapFlag = 1 << 8;     // in EFLAGS: a trap after the next instruction

  static void on_access(int, siginfo_t*, void* context) {
    greg_t* registers = static_cast<ucontext_t*>(context)->uc_mcontext.gregs;
    ++accesses;
    if ((registers[REG_ERR] & kWriteAccess) == 0) ++reads;
    ::mprotect(pages.data(), pages.size(), PROT_READ | PROT_WRITE);
    registers[REG_EFL] |= kTrapFlag;
  }
  static void after_access(int, siginfo_t*, void* context) {
    ::mprotect(pages.data(), pages.size(), PROT_NONE);
    static_cast<ucontext_t*>(context)->uc_mcontext.gregs[REG_EFL] &= ~kTrapFlag;
  }

  static inline std::span<std::byte> pages;
  struct sigaction former_fault_ {};
  struct sigaction former_trap_ {};
};

}  // namespace

TEST_CASE("The memory is never read") {
  for (const PixelFormat format : {PixelFormat::Xrgb8888, PixelFormat::Rgb565}) {
    const Pages memory(Pixels{200}, Pixels{8}, format);
    FrameWriter writer(memory.layout, memory.memory());
    Mask mask(Pixels{200}, Pixels{8});
    for (std::int32_t y = 0; y < 8; ++y)
      std::ranges::fill(mask.row(y), static_cast<std::uint8_t>(y + 1));
    std::size_t written = 0;
    {
      const ClosedPages closed(memory.memory());
      written = writer.write(mask);
      mask.row(3)[50] = 255;
      writer.write(mask);
      writer.blacken();
    }
    CHECK(written == 200 * 8 * bytes_per_pixel(format));
    CHECK(ClosedPages::accesses > 0);
    CHECK(ClosedPages::reads == 0);
  }
}
#endif
