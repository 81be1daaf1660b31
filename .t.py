import sys,glob
from pathlib import Path
from plumbline.harness.store.store import Store
from plumbline.harness.findings.agreement import agreements
from plumbline.harness.findings.agreement.happened import *
from plumbline.harness.findings.agreement.found import _scene
def main():
    for f in sorted(glob.glob("build/ten/*/trials.parquet"))+["build/quad/trials.parquet"]:
        st=Store(Path(f).parent)
        for a in agreements(st):
            sc=parse(str(st.trajectory(st.trials["trajectory_hash"].dropna().iloc[0],("scene",))["scene"]),"s.json")
            print("##",f)
            for l in happened_words(happenings(st,a),a,{}): print("   ",l)
main()
