// Whether page faults of a test are its own: sanitizers take some for accesses to their shadow memory.
#pragma once

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MLT_FAULTS_ARE_OURS 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define MLT_FAULTS_ARE_OURS 0
#endif
#endif
#ifndef MLT_FAULTS_ARE_OURS
#define MLT_FAULTS_ARE_OURS 1
#endif
