// Writes the inputs that the fuzzers start from: make-fuzz-corpus FOLDER (which gets stl/ and mask/).
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "tests/fuzz/mask_input.hpp"
#include "tests/models/damage.hpp"

namespace {

using namespace contourd;
namespace fs = std::filesystem;

void write(const fs::path& path, std::span<const std::byte> bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw std::runtime_error("cannot write " + path.string());
}

void write(const fs::path& path, const std::string& text) {
  write(path, std::as_bytes(std::span(text)));
}

models::Facets cracked_ball() {
  models::Facets facets = models::sphere(4, 6);
  models::Dice dice(1);
  models::drop_facets(facets, 0.05, dice);
  models::shake_corners(facets, 0.02, dice);
  return facets;
}

models::Facets extremes() {
  constexpr float kHuge = 3e38F, kTiny = 1e-45F;
  return {{{Vertex{-kHuge, -kHuge, -kHuge}, Vertex{kHuge, -kHuge, 0}, Vertex{0, kHuge, kHuge}}},
          {{Vertex{0, 0, -kTiny}, Vertex{kTiny, 0, kTiny}, Vertex{0, kTiny, 0}}},
          {{Vertex{1, 2, 3}, Vertex{1, 2, 3}, Vertex{-0.0F, 1e38F, 3}}}};
}

void write_stl_inputs(const fs::path& folder) {
  const models::Facets box = models::box({0, 0, 0}, {1, 2, 3});
  const std::string text = models::to_ascii_stl(box);
  write(folder / "box.stl", models::to_binary_stl(box));
  write(folder / "none.stl", models::to_binary_stl({}));
  write(folder / "extremes.stl", models::to_binary_stl(extremes()));
  write(folder / "ascii.stl", text);
  write(folder / "ascii_extremes.stl", models::to_ascii_stl(extremes()));
  write(folder / "ascii_cut.stl", text.substr(0, text.size() / 2));
  write(folder / "ascii_twice.stl", "; a comment\r\n" + text + text);
  write(folder / "no_number.stl",
        std::string(
            "SOLID x\nFACET NORMAL nan inf -1e999\nOUTER LOOP\nVERTEX 1e38 -1e-45 +.5\nVERTEX 0x1 1 1\n"));
  // Binary, but for a wrong count and a beginning that says otherwise.
  auto bytes = models::to_binary_stl(box);
  bytes[80] = std::byte{200};
  write(folder / "wrong_count.stl", bytes);
  bytes = models::to_binary_stl(box);
  std::memcpy(bytes.data(), "solid", 5);
  write(folder / "binary_solid.stl", bytes);
}

void write_mask_inputs(const fs::path& folder) {
  const fuzz::MaskSettings grey{99, 79, fuzz::kGrey, 30'000, 50, 1};
  const fuzz::MaskSettings one_bit{99, 79, fuzz::kMirrorX | fuzz::kCopies, 40'000, 100, 2};
  const fuzz::MaskSettings one_pixel{0, 0, fuzz::kGrey | fuzz::kFit, 10'000, 50, 0};
  const fuzz::MaskSettings grown{99, 79, fuzz::kGrey | 12U << 8U, 30'000, 50, 1};
  const fuzz::MaskSettings shrunk{99, 79, 250U << 8U, 30'000, 50, 1};
  const fuzz::MaskSettings long_one{16383,  2, fuzz::kGrey | fuzz::kLongDisplay | fuzz::kMirrorY,
                                    60'000, 5, 0};
  const std::pair<const char*, models::Facets> shapes[] = {{"box", models::box({0, 0, 0}, {1, 2, 3})},
                                                           {"ball", models::sphere(2, 4)},
                                                           {"cracked", cracked_ball()},
                                                           {"extremes", extremes()}};
  for (const auto& [name, facets] : shapes) {
    int number = 0;
    for (const fuzz::MaskSettings& settings : {grey, one_bit, one_pixel, grown, shrunk, long_one}) {
      write(folder / (std::string(name) + std::to_string(number++)), fuzz::to_bytes({settings, facets}));
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: make-fuzz-corpus FOLDER\n", stderr);
    return 64;
  }
  try {
    const fs::path folder = argv[1];
    fs::create_directories(folder / "stl");
    fs::create_directories(folder / "mask");
    write_stl_inputs(folder / "stl");
    write_mask_inputs(folder / "mask");
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make-fuzz-corpus: %s\n", error.what());
    return 73;
  }
}
