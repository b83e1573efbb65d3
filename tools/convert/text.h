// Text from files, fit to be a name in a scene and to stand in a sentence.
#pragma once

#include <string>
#include <string_view>

namespace fire3dv::convert {

// What is no UTF-8, a control character, or turns the direction of what follows becomes '?'; what is longer
// is cut between characters.
std::string clean_text(std::string_view text, size_t most_bytes = 1024);  // as streams' names

}  // namespace fire3dv::convert
