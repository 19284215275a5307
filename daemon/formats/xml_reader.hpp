// Reads XML from a stream, element by element, in bounded memory. Thread-safe (no shared state).
#pragma once

#include <string>
#include <string_view>

#include "daemon/formats/byte_stream.hpp"

namespace contourd {

// The attributes of an element, valid while its handler runs.
class XmlAttributes {
 public:
  explicit XmlAttributes(const char* const* names_and_values) : list_(names_and_values) {}

  // Returns the attribute's value, or nullptr. A name with a namespace is "URI|name".
  [[nodiscard]] const char* find(std::string_view name) const {
    for (const char* const* at = list_; *at != nullptr; at += 2)
      if (name == *at) return at[1];
    return nullptr;
  }
  // Does the same, but returns an empty text for a missing attribute.
  [[nodiscard]] std::string_view text(std::string_view name) const {
    const char* const value = find(name);
    return value == nullptr ? std::string_view() : value;
  }

 private:
  const char* const* list_;
};

// Handles the elements of one kind of document. Names of elements with a namespace are "URI|name".
class XmlHandler {
 public:
  XmlHandler() = default;
  XmlHandler(const XmlHandler&) = delete;
  XmlHandler& operator=(const XmlHandler&) = delete;
  virtual ~XmlHandler() = default;

  // Called before the element that declares the prefix is opened.
  virtual void name_space(std::string_view /*prefix*/, std::string_view /*uri*/) {}
  virtual void open(std::string_view name, const XmlAttributes& attributes) = 0;
  virtual void close(std::string_view /*name*/) {}
  // Called with the text between elements, in any number of pieces, if wants_text() was true after the last
  // element was opened or closed.
  virtual void text(std::string_view /*text*/) {}
  [[nodiscard]] virtual bool wants_text() const { return false; }
  // True if the document may name a document type. It is never read, must not define anything itself, and the
  // document must say that it stands alone.
  [[nodiscard]] virtual bool may_name_type() const { return false; }
};

// Reads a whole document; blocks. `name` begins messages. Throws ModelError for anything but well-formed XML
// without a document type declaration (but see may_name_type()), with at most 64 levels, whose names fit into
// 32 MB and whose tags into 1 MB; what the handler throws; and what the stream throws.
void read_xml(ByteStream& stream, XmlHandler& handler, const std::string& name);

}  // namespace contourd
