// Which level of x86-64 this processor has.
//
// The levels are those of the x86-64 ABI: 3 has AVX2 and FMA, 4 has the parts of AVX-512 that all
// server processors with AVX-512 share. The system must save their registers, too.
#pragma once

#if defined(__x86_64__) || defined(_M_X64)
#if defined(_MSC_VER) && !defined(__clang__)
#include <immintrin.h>
#include <intrin.h>
static void ask(unsigned leaf, unsigned sub, unsigned registers[4]) {
  __cpuidex((int*)registers, (int)leaf, (int)sub);
}
static unsigned long long saved_registers(void) { return _xgetbv(0); }
#else
#include <cpuid.h>
static void ask(unsigned leaf, unsigned sub, unsigned registers[4]) {
  __cpuid_count(leaf, sub, registers[0], registers[1], registers[2], registers[3]);
}
static unsigned long long saved_registers(void) {
  unsigned low, high;
  __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  return ((unsigned long long)high << 32) | low;
}
#endif

static int has(unsigned value, unsigned bits) { return (value & bits) == bits; }

static int level_of_processor(void) {
  enum { EAX, EBX, ECX, EDX };
  unsigned basic[4], more[4], extended[4], registers[4];
  ask(0, 0, registers);
  if (registers[EAX] < 7) return 2;
  ask(1, 0, basic);
  ask(7, 0, more);
  ask(0x80000000u, 0, registers);
  if (registers[EAX] < 0x80000001u) return 2;
  ask(0x80000001u, 0, extended);
  const unsigned fma = 1u << 12, movbe = 1u << 22, osxsave = 1u << 27, avx = 1u << 28;
  const unsigned f16c = 1u << 29, lzcnt = 1u << 5, bmi1 = 1u << 3, avx2 = 1u << 5, bmi2 = 1u << 8;
  if (!has(basic[ECX], fma | movbe | osxsave | avx | f16c)) return 2;
  if (!has(more[EBX], bmi1 | avx2 | bmi2) || !has(extended[ECX], lzcnt)) return 2;
  const unsigned long long saved = saved_registers();
  if ((saved & 0x6) != 0x6) return 2;  // XMM, YMM
  const unsigned f = 1u << 16, dq = 1u << 17, cd = 1u << 28, bw = 1u << 30, vl = 1u << 31;
  if (!has(more[EBX], f | dq | cd | bw | vl) || (saved & 0xe6) != 0xe6) return 3;  // and ZMM, masks
  return 4;
}
#else
static int level_of_processor(void) { return 2; }
#endif
