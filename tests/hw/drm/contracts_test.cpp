// Tests that the functions of hw/drm check their preconditions. Output is not tested here because it needs a
// card; its masks go to FrameWriters that have its mode's size.

#include "hw/drm/atomic_request.hpp"
#include "hw/drm/frame_writer.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

namespace {

alignas(4) std::array<std::byte, 4 * 5 * 3 + 1> pixel_memory;

FrameWriter::Layout layout(std::size_t stride_bytes) {
  return {.width = Pixels{5}, .height = Pixels{3}, .stride_bytes = stride_bytes};
}

std::string writing(std::size_t stride_bytes, std::size_t begin, std::size_t bytes) {
  return contract_broken_by(
      [=] { FrameWriter(layout(stride_bytes), std::span(pixel_memory).subspan(begin, bytes)); });
}

}  // namespace

TEST_CASE("FrameWriter requires memory that holds its rows and is aligned") {
  CHECK(writing(20, 0, 60).empty());
  CHECK(writing(19, 0, 60) == "a row holds its pixels");
  CHECK(writing(20, 0, 59) == "the memory holds all rows");
  CHECK(writing(20, 1, 60) == "the memory is aligned to a pixel's size");
}

TEST_CASE("FrameWriter requires masks of its size") {
  FrameWriter writer(layout(20), std::span(pixel_memory).first(60));
  CHECK(contract_broken_by([&] { writer.write(Mask(Pixels{5}, Pixels{3})); }).empty());
  CHECK(contract_broken_by([&] { writer.write(Mask(Pixels{5}, Pixels{4})); }) ==
        "the mask has the layout's size");
}

TEST_CASE("AtomicRequest requires a property before one is changed") {
  AtomicRequest request;
  CHECK(contract_broken_by([&] { request.change_last(1); }) == "a property was set");
  request.set(1, 2, 3);
  CHECK(contract_broken_by([&] { request.change_last(1); }).empty());
}
