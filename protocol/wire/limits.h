// Limits that publishers, links, recordings and renderers share. Limits of one part alone are beside its
// code.
#pragma once

#include <cstddef>

namespace fire3dv::wire {

// Bytes of one message: the poses of 5.5 million nodes. Bounds what a peer makes a reader allocate.
constexpr size_t kMaxMessageBytes = size_t{256} << 20;
// Bytes of the scene edits of one stream that are in force. A snapshot of them fits a recording's queue.
constexpr size_t kMaxSceneEditBytes = size_t{256} << 20;
// Scene edits of one stream that are in force, one for each node or marker and property. Bounds the tables of
// readers, where a key is cheap to send and dear to hold.
constexpr size_t kMaxSceneEdits = 65'536;

}  // namespace fire3dv::wire
