import sys,glob
from pathlib import Path
from plumbline.harness.store.store import Store
from plumbline.harness.findings import tables
def main():
    for f in sys.argv[1:]:
        st=Store(Path(f))
        T=tables.table("agreement")
        print("##",f)
        for l in T.sentences(T.rows(st)): print("   ",l)
main()
