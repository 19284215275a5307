#include "daemon/formats/xml_reader.hpp"

#include <expat.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <exception>
#include <memory>
#include <new>
#include <span>

#include "core/model/model.hpp"

namespace contourd {
namespace {

constexpr int kMostLevels = 64;
constexpr int kChunkBytes = 65'536;
// The longest tag that is certain to be read. Expat 2.5 begins a tag again with every chunk: the time for a
// longer one would grow with its square (CVE-2023-52425).
constexpr XML_Index kLongestTagBytes = XML_Index{1} << 20U;
// Since the mending of that, Expat waits for twice the bytes before it begins a tag again.
constexpr XML_Index kMostWaitingBytes = 2 * kLongestTagBytes + kChunkBytes;
constexpr std::size_t kMostParserBytes = std::size_t{1} << 25U;

// The memory of the parsers of this thread. The parser keeps every name that it meets, and the whole of a
// tag: a hostile file could fill the memory with either.
thread_local std::size_t parser_bytes = 0;

struct alignas(std::max_align_t) BlockHeader {
  std::size_t bytes;
};

void* reallocate_block(void* block, std::size_t bytes) {
  BlockHeader* const old = block == nullptr ? nullptr : static_cast<BlockHeader*>(block) - 1;
  const std::size_t old_bytes = old == nullptr ? 0 : old->bytes;
  if (bytes > kMostParserBytes || parser_bytes - old_bytes + bytes > kMostParserBytes) return nullptr;
  auto* const made = static_cast<BlockHeader*>(std::realloc(old, sizeof(BlockHeader) + bytes));
  if (made == nullptr) return nullptr;
  parser_bytes += bytes - old_bytes;
  made->bytes = bytes;
  return made + 1;
}

void* allocate_block(std::size_t bytes) {
  return reallocate_block(nullptr, bytes);
}

void free_block(void* block) {
  if (block == nullptr) return;
  BlockHeader* const header = static_cast<BlockHeader*>(block) - 1;
  parser_bytes -= header->bytes;
  std::free(header);
}

constexpr XML_Memory_Handling_Suite kBoundedMemory{allocate_block, reallocate_block, free_block};

struct FreeParser {
  void operator()(XML_Parser parser) const { XML_ParserFree(parser); }
};
using Parser = std::unique_ptr<XML_ParserStruct, FreeParser>;

// One document that is read. Exceptions must not pass through the parser, which is C: they wait until it has
// returned.
class Reading {
 public:
  Reading(XmlHandler& handler, const std::string& name)
      : handler_(handler), name_(name), parser_(XML_ParserCreate_MM(nullptr, &kBoundedMemory, "|")) {
    if (!parser_) throw std::bad_alloc();
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(parser_.get(), opened, closed);
    XML_SetStartNamespaceDeclHandler(parser_.get(), declared);
    XML_SetStartDoctypeDeclHandler(parser_.get(), doctype);
    XML_SetNotStandaloneHandler(parser_.get(), not_standalone);
  }

  void read(ByteStream& stream) {
    XML_Index fed = 0;
    for (bool ended = false; !ended;) {
      void* const buffer = XML_GetBuffer(parser_.get(), kChunkBytes);
      if (buffer == nullptr) refuse();
      const std::size_t bytes = stream.read_some({static_cast<std::byte*>(buffer), kChunkBytes});
      ended = bytes == 0;
      if (XML_ParseBuffer(parser_.get(), static_cast<int>(bytes), ended ? XML_TRUE : XML_FALSE) !=
          XML_STATUS_OK)
        refuse();
      fed += static_cast<XML_Index>(bytes);
      if (fed - std::max<XML_Index>(XML_GetCurrentByteIndex(parser_.get()), 0) > kMostWaitingBytes) refuse();
    }
  }

 private:
  template <typename Work>
  void guarded(Work work) noexcept {
    if (failure_) return;
    try {
      work();
    } catch (...) {
      failure_ = std::current_exception();
      XML_StopParser(parser_.get(), XML_FALSE);
    }
  }

  static void opened(void* self, const char* name, const char** attributes) {
    auto& reading = *static_cast<Reading*>(self);
    reading.guarded([&] {
      if (++reading.levels_ > kMostLevels)
        throw ModelError(fmt::format("its elements are nested more than {} levels deep", kMostLevels));
      reading.handler_.open(name, XmlAttributes(attributes));
      reading.pass_text();
    });
  }
  static void closed(void* self, const char* name) {
    auto& reading = *static_cast<Reading*>(self);
    reading.guarded([&] {
      --reading.levels_;
      reading.handler_.close(name);
      reading.pass_text();
    });
  }
  // Most of a model's text is blanks between its elements, which take time.
  void pass_text() {
    XML_SetCharacterDataHandler(parser_.get(), handler_.wants_text() ? characters : nullptr);
  }
  static void characters(void* self, const char* text, int bytes) {
    auto& reading = *static_cast<Reading*>(self);
    reading.guarded([&] { reading.handler_.text({text, static_cast<std::size_t>(bytes)}); });
  }
  static void declared(void* self, const char* prefix, const char* uri) {
    auto& reading = *static_cast<Reading*>(self);
    reading.guarded(
        [&] { reading.handler_.name_space(prefix == nullptr ? "" : prefix, uri == nullptr ? "" : uri); });
  }
  static void doctype(void* self, const char* /*name*/, const char* /*system*/, const char* /*public*/,
                      int has_internal_subset) {
    auto& reading = *static_cast<Reading*>(self);
    if (has_internal_subset == 0 && reading.handler_.may_name_type()) return;
    reading.guarded(
        [] { throw ModelError("it has a document type declaration, which such files must not have"); });
  }

  // Without "standalone", the parser would leave out what a document type that is not read could define.
  static int not_standalone(void* self) {
    static_cast<Reading*>(self)->guarded([] {
      throw ModelError(
          "it names a document type, and does not say standalone=\"yes\": slice the model again");
    });
    return XML_STATUS_ERROR;
  }

  [[noreturn]] void refuse() const {
    const auto line = XML_GetCurrentLineNumber(parser_.get());
    const XML_Error error = XML_GetErrorCode(parser_.get());
    try {
      if (failure_) std::rethrow_exception(failure_);
    } catch (const ModelError& refusal) {
      throw ModelError(fmt::format("{}: line {}: {}", name_, line, refusal.what()));
    }
    if (error == XML_ERROR_NO_MEMORY || error == XML_ERROR_NONE)
      throw ModelError(fmt::format(
          "{}: line {}: its names or one of its tags are too long: write the file with another program",
          name_, line));
    throw ModelError(fmt::format("{}: line {}: it is not valid XML ({}): export the model again", name_, line,
                                 XML_ErrorString(error)));
  }

  XmlHandler& handler_;
  const std::string& name_;
  std::exception_ptr failure_;
  int levels_ = 0;
  Parser parser_;
};

}  // namespace

void read_xml(ByteStream& stream, XmlHandler& handler, const std::string& name) {
  Reading(handler, name).read(stream);
}

}  // namespace contourd
